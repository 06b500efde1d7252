"""Crowds: scenes of N proxies, on which engines say which pairs touch, or whose boxes overlap."""
