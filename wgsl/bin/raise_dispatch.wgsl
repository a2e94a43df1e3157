// Workgroup counts that only the GPU knows: zero before each batch, then raised by atomicMax, so that the
// largest of many invocations stays, in whatever order they come.

import package::bind::changed::dispatches;

const MAX_X: u32 = 32768u; // below every adapter's limit of workgroups in a row

fn raise_dispatch(dispatch: u32, count: u32, slices: u32) {
    atomicMax(&dispatches[4u * dispatch], min(count, MAX_X));
    atomicMax(&dispatches[4u * dispatch + 1u], (count + MAX_X - 1u) / MAX_X);
    atomicMax(&dispatches[4u * dispatch + 2u], slices);
    atomicMax(&dispatches[4u * dispatch + 3u], count);
}
