//! Sizes and workgroup counts of a frame as formulas: the library evaluates them, and `gobo export` prints
//! them for engines that run a frame by themselves.
use std::fmt;

macro_rules! numbers {
    ($($variant:ident $name:literal $meaning:literal,)*) => {
        /// Variables of formulas: properties of a frame, and the partition of its work.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Number {
            $(#[doc = $meaning] $variant,)*
        }

        impl Number {
            pub const ALL: &'static [Self] = &[$(Self::$variant,)*];

            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// Meaning of the variable.
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$variant => $meaning,)* }
            }
        }
    };
}

numbers! {
    ViewCount "view_count" "views of the batch, at most 64, all of them perspective ones or none",
    TileCount "tile_count" "tiles of 16x16 texels of all views of the batch, at most 65536",
    ChunkCount "chunk_count" "chunks of the list at hand",
    ParticleChunks "particle_chunk_count" "chunks of particles, of at most 256 of one view each",
    TriangleChunks "triangle_chunk_count" "chunks of triangles, of at most 256 of one view each",
    TinyChunks "tiny_chunk_count" "those chunks of particles that take the scatter path where they are tiny",
    FootprintCount "footprint_count" "(caster, view) of the list: particles first, then triangles",
    SetupCount "setup_count" "(triangle, view) of the list",
    FirstSetup "first_setup" "(particle, view) of the list: the footprint of the first triangle",
    CasterCount "caster_count" "records of particles in `casters`",
    TriangleCount "triangle_count" "records of `triangles`",
    ImageWidth "image_width" "of the largest texture of a material, at least 1 [texels]",
    ImageHeight "image_height" "of the largest texture of a material, at least 1 [texels]",
    ImageCount "image_count" "textures of materials, at least 1",
    PairCapacity "pair_capacity" "(caster, tile) that there is memory for: any number from 1; what does not fit is scattered, which costs time and no light",
    SegmentLength "segment_length" "pairs that one workgroup walks",
    Nodes "nodes" "nodes of a curve: 4, 8 or 16; 0 for the nearest depth alone",
    Changes "changes" "1: the list has `over` or volumes, whose segments leave more",
    Scatter "scatter" "1: tiny particles skip sort and bin; 0 where there are curves",
    IncludeNonCasters "include_non_casters" "1: what casts nothing is seen too, by a camera",
    ByDistance "by_distance" "1: perspective views sort by distance, as `over` needs it",
    Width "width" "of the atlas of maps [texels]",
    Height "height" "of the atlas of maps [texels]",
    Layers "layers" "of the atlas of maps",
    BinLanes "bin_lanes" "invocations of a workgroup of `bin_count` and `bin_emit`",
    UsualRuns "usual_runs" "runs that share the footprints of a list, where no run gets too long",
    SortLanes "sort_lanes" "partitions, and digits, of a workgroup of the sort",
    DigitBits "digit_bits" "bits of a digit of the sort at most",
    PartitionLimit "partition_limit" "partitions of the list that is sorted, by its capacity",
    SortCapacity "sort_capacity" "pairs that the sort at hand has memory for",
    KeyBits "key_bits" "bits of the keys that the sort at hand goes by",
    Digit "digit" "number of the digit at hand, lowest first",
}

const COUNT: usize = Number::ALL.len();

/// Values of variables; 0 by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Numbers([u64; COUNT]);

impl Numbers {
    #[must_use]
    pub fn with(mut self, number: Number, value: impl Into<u64>) -> Self {
        self.0[number as usize] = value.into();
        self
    }

    pub fn get(&self, number: Number) -> u64 {
        self.0[number as usize]
    }
}

/// An integer formula without overflow or division by zero.
#[derive(Clone, Copy, Debug)]
pub enum Formula {
    Is(u64),
    Of(Number),
    /// A named subformula.
    Named(&'static str, &'static Self),
    Sum(&'static Self, &'static Self),
    /// 0 if the second is larger.
    Difference(&'static Self, &'static Self),
    Product(&'static Self, &'static Self),
    /// Rounded down.
    Quotient(&'static Self, &'static Self),
    /// Rounded up.
    QuotientUp(&'static Self, &'static Self),
    Remainder(&'static Self, &'static Self),
    Least(&'static Self, &'static Self),
    Most(&'static Self, &'static Self),
    /// Two to the power of a number up to 63.
    Power(&'static Self),
    /// Number of binary digits.
    Bits(&'static Self),
    /// Fewest rows that divide a number of workgroups evenly, with at most 65,535 in each.
    Rows(&'static Self),
}

impl Formula {
    pub fn of(&self, numbers: &Numbers) -> u64 {
        let of = |formula: &Self| formula.of(numbers);
        match *self {
            Self::Is(value) => value,
            Self::Of(number) => numbers.get(number),
            Self::Named(_, formula) => of(formula),
            Self::Sum(a, b) => of(a).saturating_add(of(b)),
            Self::Difference(a, b) => of(a).saturating_sub(of(b)),
            Self::Product(a, b) => of(a).saturating_mul(of(b)),
            Self::Quotient(a, b) => of(a).checked_div(of(b)).unwrap_or(0),
            Self::QuotientUp(a, b) => of(a).div_ceil(of(b).max(1)),
            Self::Remainder(a, b) => of(a).checked_rem(of(b)).unwrap_or(0),
            Self::Least(a, b) => of(a).min(of(b)),
            Self::Most(a, b) => of(a).max(of(b)),
            Self::Power(a) => 1 << of(a).min(63),
            Self::Bits(a) => u64::from(u64::BITS - of(a).leading_zeros()),
            Self::Rows(a) => rows(of(a)),
        }
    }

    /// Like [`Self::of`], clamped to `u32`.
    pub fn count(&self, numbers: &Numbers) -> u32 {
        u32::try_from(self.of(numbers)).unwrap_or(u32::MAX)
    }

    /// The formula and all its parts, parts first.
    pub fn parts(&self) -> Vec<Self> {
        let mut parts = match *self {
            Self::Is(_) | Self::Of(_) => Vec::new(),
            Self::Named(_, a) | Self::Power(a) | Self::Bits(a) | Self::Rows(a) => a.parts(),
            Self::Sum(a, b)
            | Self::Difference(a, b)
            | Self::Product(a, b)
            | Self::Quotient(a, b)
            | Self::QuotientUp(a, b)
            | Self::Remainder(a, b)
            | Self::Least(a, b)
            | Self::Most(a, b) => [a.parts(), b.parts()].concat(),
        };
        parts.push(*self);
        parts
    }
}

fn rows(count: u64) -> u64 {
    const MAX_X: u64 = 65535;
    let fits = |rows: &u64| count.is_multiple_of(*rows) && count / rows <= MAX_X;
    (1..=count).find(fits).unwrap_or(1)
}

/// Syntax of `docs/export.md`: names, numbers, `+ - * / %` in parentheses, functions.
impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Is(value) => write!(f, "{value}"),
            Self::Of(number) => f.write_str(number.name()),
            Self::Named(name, _) => f.write_str(name),
            Self::Sum(a, b) => write!(f, "({a} + {b})"),
            Self::Difference(a, b) => write!(f, "({a} - {b})"),
            Self::Product(a, b) => write!(f, "({a} * {b})"),
            Self::Quotient(a, b) => write!(f, "({a} / {b})"),
            Self::Remainder(a, b) => write!(f, "({a} % {b})"),
            Self::QuotientUp(a, b) => write!(f, "div_up({a}, {b})"),
            Self::Least(a, b) => write!(f, "min({a}, {b})"),
            Self::Most(a, b) => write!(f, "max({a}, {b})"),
            Self::Power(a) => write!(f, "power({a})"),
            Self::Bits(a) => write!(f, "bits({a})"),
            Self::Rows(a) => write!(f, "rows({a})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Formula::{
        Bits, Difference, Is, Least, Of, Power, Product, Quotient, QuotientUp, Rows, Sum,
    };

    #[test]
    fn formulas_read_as_they_count() {
        const HALVES: Formula = QuotientUp(&Of(Number::Nodes), &Is(2));
        const ALL: Formula = Sum(&Product(&Is(3), &HALVES), &Quotient(&Is(7), &Is(2)));
        let numbers = Numbers::default().with(Number::Nodes, 5_u32);
        assert_eq!(ALL.to_string(), "((3 * div_up(nodes, 2)) + (7 / 2))");
        assert_eq!(ALL.of(&numbers), 12);
        assert_eq!(Difference(&Is(3), &Is(5)).of(&numbers), 0);
        assert_eq!(Quotient(&Is(3), &Is(0)).of(&numbers), 0);
        assert_eq!(Least(&Is(3), &Of(Number::Width)).of(&numbers), 0);
        assert_eq!([0, 1, 255, 256].map(|n| bits(n).of(&numbers)), [0, 1, 8, 9]);
        assert_eq!(Power(&Is(6)).of(&numbers), 64);
        assert_eq!(ALL.parts().len(), 9);
    }

    fn bits(value: u64) -> Formula {
        Bits(Box::leak(Box::new(Is(value))))
    }

    #[test]
    fn rows_are_even_and_not_too_long() {
        for (count, wanted) in
            [(0, 1), (1, 1), (65535, 1), (65536, 2), (3 * 65535, 3), (65537, 65537)]
        {
            let formula = Rows(Box::leak(Box::new(Is(count))));
            assert_eq!(formula.of(&Numbers::default()), wanted, "{count}");
        }
    }
}
