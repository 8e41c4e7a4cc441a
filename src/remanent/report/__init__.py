"""The paper's reproduction and the audit of its claims."""
