// Closed meshes absorb along the way through them: their sums are signed, and faces behind the
// opaque surface count.
override HAS_VOLUMES: bool;
