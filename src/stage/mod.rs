//! The pipeline, stage by stage, in dispatch order.
