"""Kernel launches: programs, memory and arguments."""
