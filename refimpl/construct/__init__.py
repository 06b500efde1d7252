"""From points and meshes to proxies: bounding volumes, and colliders that approximate."""
