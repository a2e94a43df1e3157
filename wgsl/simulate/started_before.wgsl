// Number of an emitter's particles that have started before one of the steps of a dispatch, or after the
// last.

import package::bind::uniform::emitter_params;

fn started_before(step: u32) -> u32 {
    return emitter_params.started[step / 4u][step % 4u];
}
