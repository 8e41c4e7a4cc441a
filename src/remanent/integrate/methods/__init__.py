"""Integration methods, and what makes one step of them."""
