mod recording;
mod layers;
