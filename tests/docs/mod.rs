mod stages;
mod paths;
