mod emitters;
mod fluids;
mod animate;
