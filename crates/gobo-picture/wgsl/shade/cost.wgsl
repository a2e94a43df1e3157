// Cost counters of a pixel, for --debug cost, where they replace its colour.

import package::features::COUNT_COST;

var<private> walked: u32; // pairs that the invocation visited

fn count_pair() {
    if COUNT_COST {
        walked += 1u;
    }
}
