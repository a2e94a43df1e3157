// What a pixel costs, for --debug cost: its colour is then replaced by these counts.

import package::features::COUNT_COST;

var<private> walked: u32; // pairs that the invocation visited
var<private> asked: u32;  // lights that it asked

fn count_pair() {
    if COUNT_COST {
        walked += 1u;
    }
}

fn count_lights(count: u32) {
    if COUNT_COST {
        asked += count;
    }
}
