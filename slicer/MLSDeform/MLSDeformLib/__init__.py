"""The module MLS Deform without its window."""
