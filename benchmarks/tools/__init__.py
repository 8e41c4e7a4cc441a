"""One file for each tool: how the work is written for it, in its best form that we know."""
