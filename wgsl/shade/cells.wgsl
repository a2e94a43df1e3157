// Cells that a box covers, row by row: texels of a map, or blocks of a level. Rows are sheared with the spot.

import package::shade::spot::{spot_shear, turned};

// Offsets are along the box's axes.
struct Cells {
    middle: vec2<f32>, // of the box
    reach: vec2<f32>,  // of the centres of cells
    off: vec2<f32>,    // of a cell's centre from the middle
}

fn cells_around(center: vec2<f32>, reach: vec2<f32>) -> Cells {
    let middle = turned(center);
    return in_row(Cells(middle, reach, vec2(0.0)), ceil(middle.y - reach.y) - middle.y);
}

// The first cell of a row, which starts anywhere between two cells.
fn in_row(cells: Cells, row: f32) -> Cells {
    let middle = cells.middle.x + spot_shear * row;
    return Cells(cells.middle, cells.reach, vec2(ceil(middle - cells.reach.x) - middle, row));
}

// The cell's place in the map or level. Cells are counted in floats: division of integers is slow on
// llvmpipe.
fn cell_at(cells: Cells) -> vec2<f32> {
    let along = vec2(cells.off.x + spot_shear * cells.off.y, cells.off.y);
    return turned(round(cells.middle + along));
}

fn next_cell(cells: Cells) -> Cells {
    let column = cells.off.x + 1.0;
    if column > cells.reach.x {
        return in_row(cells, cells.off.y + 1.0);
    }
    return Cells(cells.middle, cells.reach, vec2(column, cells.off.y));
}

// Whether no cell is left.
fn is_past(cells: Cells) -> bool {
    return cells.off.y > cells.reach.y;
}
