// A caster of the batch adds light: the order counts, and saturation is no end.
override HAS_OVER: bool;
