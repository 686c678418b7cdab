"""Sampling on a device: values, gradients and void cells."""
