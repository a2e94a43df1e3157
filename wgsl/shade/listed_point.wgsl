// Points that a dispatch evaluates: a list of the band, or all points of a batch.

import package::bind::read::point_lists;
import package::bind::uniform::point_batch;
import package::records::point_list::{LIST_HEAD, LIST_LENGTH, NO_LIST};

fn is_listed() -> bool {
    return point_batch.list != NO_LIST;
}

fn point_count() -> u32 {
    let head = select(0u, point_batch.list * LIST_HEAD, is_listed());
    return select(point_batch.count, point_lists[head + LIST_LENGTH], is_listed());
}

fn point_at(index: u32) -> u32 {
    let entry = select(0u, point_batch.first + index, is_listed());
    return select(index, point_lists[entry], is_listed());
}
