// Casters in a buffer that is laid out as `Caster` is. A host's own text takes the place of this file.

import package::bind::read::host_casters;
import package::records::host::Caster;

fn load_caster(index: u32) -> Caster {
    return host_casters[index];
}
