// Gaussians in a buffer with the layout of `Gaussian`. A host's own text replaces this file.

import package::bind::read::host_gaussians;
import package::records::host::Gaussian;

fn load_gaussian(index: u32) -> Gaussian {
    return host_gaussians[index];
}
