"""The reproduction of [Thermal] and the audit of its claims."""
