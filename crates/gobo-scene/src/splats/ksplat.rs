//! `.ksplat` (mkkellogg/GaussianSplats3D, version 0.1): sections of splats, in buckets; positions are stored
//! relative to a bucket's centre. Numbers are plain floats, halves, or halves with harmonics of 8 bits
//! (compression levels 0, 1 and 2).
use super::{
    cloud::{SplatCloud, word},
    harmonics::Harmonics,
};
use crate::{error::Fault, limits::Limit};
use glam::{Quat, Vec3};
use gobo::model::Gaussian;
use half::f16;

/// Length of the header of the file, and of each section \[bytes\].
const HEADER: usize = 4096;
const SECTION: usize = 1024;

/// Size of a bucket's centre \[bytes\].
const CENTER: usize = 12;

/// Numbers of higher harmonics per splat, by degree.
const HARMONICS: [u64; 4] = [0, 9, 24, 45];

/// Size of a record before its harmonics, by the level of compression \[bytes\].
const PLAIN: [usize; 3] = [44, 24, 24];

/// First number, and numbers per channel, of the bands of higher harmonics in a record: channel by channel.
const BANDS: [(usize, usize); 3] = [(0, 3), (9, 5), (24, 7)];

/// Range of harmonics in bytes unless the header states it: from its negative.
const USUAL_HARMONIC: f32 = 1.5;

/// Range of 16-bit positions unless the section states it.
const USUAL_RANGE: u32 = 32767;

const DAMAGED: &str = "the file is cut off or damaged: write it again";

/// Header of the file.
struct KsplatHeader {
    sections: u64,
    count: u64,
    level: u16,
    /// Coefficients of harmonics whose bytes are 0 and 255.
    harmonics: [f32; 2],
}

impl KsplatHeader {
    /// `None` if the bytes begin no such file.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let number = |i: usize| u32::from_le_bytes(word(bytes, i));
        if bytes.len() < HEADER || bytes[0] != 0 || bytes[1] == 0 {
            return None;
        }
        let level = u16::from_le_bytes([bytes[20], bytes[21]]);
        let (most_sections, sections) = (number(1), number(2));
        let (most, count) = (number(3), number(4));
        let given = [9, 10].map(|i| f32::from_le_bytes(word(bytes, i)));
        let end = |given: f32, usual: f32| if given == 0.0 { usual } else { given };
        let harmonics = [end(given[0], -USUAL_HARMONIC), end(given[1], USUAL_HARMONIC)];
        let is_known = level <= 2 && sections >= 1 && sections <= most_sections && count <= most;
        let (sections, count) = (most_sections.into(), count.into());
        is_known.then_some(Self { sections, count, level, harmonics })
    }

    /// Offset of the data of the first section \[bytes\].
    fn start(&self) -> u64 {
        HEADER as u64 + self.sections * SECTION as u64
    }
}

/// Header of a section.
struct Section {
    count: u64,
    /// Splats of a full bucket, and number of full buckets.
    capacity: u64,
    full: u64,
    /// Buckets with a length of their own.
    partial: u64,
    buckets: u64,
    /// Edge of the cube around a bucket's centre \[m\].
    edge: f32,
    range: u32,
    degree: u16,
    /// Sizes of a bucket's centre, and of a splat \[bytes\].
    center: u64,
    size: u64,
    /// Number of splats that there is space for.
    room: u64,
}

impl Section {
    fn parse(bytes: &[u8], level: u16) -> Result<Self, Fault> {
        let number = |i: usize| u32::from_le_bytes(word(bytes, i));
        let short = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let degree = short(40);
        let Some(&numbers) = HARMONICS.get(usize::from(degree)) else {
            return Err((format!("spherical harmonics of degree {degree}"), DAMAGED));
        };
        let (plain, number_size) = (PLAIN[usize::from(level)], [4, 2, 1][usize::from(level)]);
        let range = number(6);
        Ok(Self {
            count: number(0).into(),
            room: number(1).into(),
            capacity: number(2).into(),
            buckets: number(3).into(),
            edge: f32::from_le_bytes(word(bytes, 4)),
            center: short(20).into(),
            range: if range == 0 { USUAL_RANGE } else { range },
            full: number(8).into(),
            partial: number(9).into(),
            degree,
            size: plain as u64 + numbers * number_size,
        })
    }

    /// Length of its lists of buckets, and of all its data \[bytes\]; 32-bit fields cannot overflow 64 bits
    /// here.
    fn lengths(&self) -> [u64; 2] {
        let lists = 4 * self.partial + self.center * self.buckets;
        [lists, lists + self.size * self.room.max(self.count)]
    }
}

/// Whether bytes begin such a file of `length` bytes.
pub(super) fn is_ksplat(start: &[u8], length: u64) -> bool {
    let Some(header) = KsplatHeader::parse(start) else { return false };
    let Some(bytes) = start.get(HEADER..HEADER + SECTION) else { return false };
    let fits = |section: Section| header.start() + section.lengths()[1] <= length;
    Section::parse(bytes, header.level).is_ok_and(fits)
}

/// Number of splats that a header announces.
pub(super) fn announced(start: &[u8]) -> Option<u64> {
    KsplatHeader::parse(start).map(|header| header.count)
}

/// A file whose counts are checked.
struct Ksplat<'a> {
    header: KsplatHeader,
    sections: Vec<Section>,
    /// Data of all sections.
    data: &'a [u8],
}

impl<'a> Ksplat<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, Fault> {
        let Some(header) = KsplatHeader::parse(bytes) else {
            return Err(("the header is not that of a .ksplat 0.1".to_owned(), DAMAGED));
        };
        Limit::Splats.grown(0, header.count)?;
        let ends = |what: &str| (format!("the file ends in {what}"), DAMAGED);
        let start = usize::try_from(header.start()).unwrap_or(usize::MAX);
        let heads = bytes.get(HEADER..start).ok_or_else(|| ends("the headers of its sections"))?;
        let data = &bytes[start..];
        let sections = heads.chunks_exact(SECTION).map(|head| Section::parse(head, header.level));
        let sections = sections.collect::<Result<Vec<_>, Fault>>()?;
        let count: u64 = sections.iter().map(|section| section.count).sum();
        if count != header.count {
            let message = format!("its sections have {count} splats, and it says {}", header.count);
            return Err((message, DAMAGED));
        }
        let lengths = sections.iter().map(|section| section.lengths()[1]);
        let all = lengths.fold(0, |sum: u64, length| sum.saturating_add(length));
        if all > data.len() as u64 {
            let message = format!("the file ends in its sections: {} of {all} bytes", data.len());
            return Err((message, DAMAGED));
        }
        Ok(Self { header, sections, data })
    }

    /// Coefficients of higher harmonics per splat and channel.
    fn harmonics(&self) -> usize {
        let degree = self.sections.iter().map(|section| section.degree).max().unwrap_or(0);
        (usize::from(degree) + 1).pow(2) - 1
    }

    /// Gives the lists and the records of each section.
    fn each(
        &self,
        mut take: impl FnMut(&Section, &'a [u8], std::slice::ChunksExact<'a, u8>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let mut rest = self.data;
        for section in &self.sections {
            let [lists, all] = section.lengths().map(|length| length as usize);
            let (data, behind) = rest.split_at(all);
            rest = behind;
            let (lists, splats) = data.split_at(lists);
            let own = section.size as usize * section.count as usize;
            take(section, lists, splats[..own].chunks_exact(section.size as usize))?;
        }
        Ok(())
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<SplatCloud, Fault> {
    let file = Ksplat::open(bytes)?;
    let level = file.header.level;
    let mut cloud = SplatCloud::with_room(file.header.count)?;
    let mut sections = 0;
    file.each(|section, lists, records| {
        sections += 1;
        let buckets = Buckets::new(section, lists, level)?;
        for (number, record) in records.enumerate() {
            let base = buckets.center(number as u64).ok_or_else(|| {
                let message = format!("section {sections}: splat {} is in no bucket", number + 1);
                (message, DAMAGED)
            })?;
            cloud.push(splat(record, level, base, section));
        }
        Ok(())
    })?;
    cloud.leave_out_harmonics(file.harmonics());
    Ok(cloud.finish())
}

/// Coefficients of higher harmonics, 0 in sections without them.
pub(super) fn harmonics(bytes: &[u8]) -> Result<Harmonics, Fault> {
    let file = Ksplat::open(bytes)?;
    let (level, [least, most]) = (file.header.level, file.header.harmonics);
    let mut all = Harmonics::with_room(file.harmonics(), file.header.count)?;
    let place = |k: usize, channel: usize| {
        let (band, before) = [(0, 0), (1, 3), (2, 8)][usize::from(k >= 3) + usize::from(k >= 8)];
        let (first, each) = BANDS[band];
        first + channel * each + k - before
    };
    file.each(|_, _, records| {
        for record in records {
            let numbers = &record[PLAIN[usize::from(level)]..];
            let number = |i: usize| match level {
                0 => {
                    numbers.as_chunks::<4>().0.get(i).map_or(0.0, |four| f32::from_le_bytes(*four))
                }
                1 => numbers
                    .as_chunks::<2>()
                    .0
                    .get(i)
                    .map_or(0.0, |two| f16::from_le_bytes(*two).to_f32()),
                _ => numbers
                    .get(i)
                    .map_or(0.0, |&byte| least + f32::from(byte) / 255.0 * (most - least)),
            };
            let of = |k: usize| [0, 1, 2].map(|channel| number(place(k, channel)));
            all.coefficients.extend((0..all.count).map(of));
        }
        Ok(())
    })?;
    Ok(all)
}

/// Bucket centres by splat.
struct Buckets<'a> {
    centers: &'a [u8],
    stride: usize,
    capacity: u64,
    full: u64,
    /// Index of the first splat of each bucket after the full ones, and the end of the last.
    firsts: Vec<u64>,
    /// Whether positions are relative to centres.
    counts: bool,
}

impl<'a> Buckets<'a> {
    fn new(section: &Section, lists: &'a [u8], level: u16) -> Result<Self, Fault> {
        let counts = level > 0;
        let (lengths, centers) = lists.split_at(4 * section.partial as usize);
        if counts && section.buckets > 0 && (section.center as usize) < CENTER {
            return Err((format!("centres of buckets of {} bytes", section.center), DAMAGED));
        }
        let mut firsts = vec![section.full.saturating_mul(section.capacity)];
        for length in lengths.as_chunks::<4>().0 {
            let length = u64::from(u32::from_le_bytes(*length));
            firsts.push(firsts[firsts.len() - 1].saturating_add(length));
        }
        let (stride, capacity, full) = (section.center as usize, section.capacity, section.full);
        Ok(Self { centers, stride, capacity, full, firsts, counts })
    }

    /// Centre of the bucket of a splat.
    fn center(&self, splat: u64) -> Option<Vec3> {
        if !self.counts {
            return Some(Vec3::ZERO);
        }
        let bucket = if splat < self.firsts[0] {
            splat.checked_div(self.capacity)?
        } else {
            let before = self.firsts.partition_point(|&first| first <= splat);
            if before == self.firsts.len() {
                return None;
            }
            self.full + before as u64 - 1
        };
        let start = usize::try_from(bucket).ok()?.checked_mul(self.stride)?;
        let bytes = self.centers.get(start..start.checked_add(CENTER)?)?;
        Some(Vec3::from_array([0, 1, 2].map(|i| f32::from_le_bytes(word(bytes, i)))))
    }
}

/// A record: centre, deviations, rotation w x y z, and bytes rgba.
fn splat(record: &[u8], level: u16, base: Vec3, section: &Section) -> Gaussian {
    let short = |i: usize| u16::from_le_bytes([record[2 * i], record[2 * i + 1]]);
    let number = |i: usize| {
        if level == 0 {
            f32::from_le_bytes(word(record, i))
        } else {
            f16::from_bits(short(i)).to_f32()
        }
    };
    let center = if level == 0 {
        Vec3::new(number(0), number(1), number(2))
    } else {
        let step = section.edge / 2.0 / section.range as f32;
        let part = |i: usize| (f64::from(short(i)) - f64::from(section.range)) as f32 * step;
        base + Vec3::new(part(0), part(1), part(2))
    };
    let [r, g, b, a] = word(record, if level == 0 { 10 } else { 5 });
    Gaussian {
        center,
        sigma: Vec3::new(number(3), number(4), number(5)),
        rotation: Quat::from_xyzw(number(7), number(8), number(9), number(6)),
        opacity: f32::from(a) / 255.0,
        color: Vec3::new(r.into(), g.into(), b.into()) / 255.0,
        ..Gaussian::default()
    }
}
