// Casters in a buffer with the layout of `Caster`. A host's own text replaces this file.

import package::bind::read::host_casters;
import package::records::host::Caster;

fn load_caster(index: u32) -> Caster {
    return host_casters[index];
}
