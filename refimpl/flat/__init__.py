"""The flat world: two dimensions."""
