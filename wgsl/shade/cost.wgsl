// What a pixel costs, for --debug cost: its colour is then replaced by these counts.

import package::features::COUNT_COST;

var<private> walked: u32; // pairs that the invocation visited

fn count_pair() {
    if COUNT_COST {
        walked += 1u;
    }
}
