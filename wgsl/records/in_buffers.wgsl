// Records from the buffers that they were written to.

import package::bind::read::casters;
import package::records::record::CasterRecord;

fn caster_record(index: u32) -> CasterRecord {
    return casters[index];
}
