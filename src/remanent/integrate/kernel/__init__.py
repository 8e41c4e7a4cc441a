"""Compiled kernels: a method, a field and error control as LLVM code."""
