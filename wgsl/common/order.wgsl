// What makes light more than a product of factors: segments of a tile are then composed one by one.

// A caster of the batch adds light: the order counts, and saturation is no end.
override HAS_OVER: bool;
// Closed meshes absorb along the way through them: their sums are signed, and faces behind the
// opaque surface count.
override HAS_VOLUMES: bool;
