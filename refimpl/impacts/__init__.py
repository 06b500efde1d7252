"""Impacts."""
