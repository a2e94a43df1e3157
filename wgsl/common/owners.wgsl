// Some receiver is tinted by all casters but its own: maps say whose the nearest depth is.
override HAS_OWNERS: bool;
