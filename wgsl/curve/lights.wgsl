// Light of an invocation's texels. CPU reference: crates/gobo-reference/src/curve/mod.rs.

import package::curve::node::DEPTHS;
import package::features::{HAS_GAIN, HAS_OVER, HAS_VOLUMES, unrolled};
import choice::rows::{ROW_COUNT, RowBits, RowIs, Rows, row, row_bits, with_bits, with_row};

struct Lights {
    red: Rows,
    green: Rows,
    blue: Rows,
}

fn white() -> Lights {
    return Lights(Rows(1.0), Rows(1.0), Rows(1.0));
}

fn black() -> Lights {
    return Lights(Rows(0.0), Rows(0.0), Rows(0.0));
}

fn light_row(v: Lights, i: u32) -> vec3<f32> {
    return vec3(row(v.red, i), row(v.green, i), row(v.blue, i));
}

fn with_light(v: Lights, i: u32, value: vec3<f32>) -> Lights {
    return Lights(
        with_row(v.red, i, value.r),
        with_row(v.green, i, value.g),
        with_row(v.blue, i, value.b),
    );
}

fn scaled(a: Lights, b: Lights) -> Lights {
    return Lights(a.red * b.red, a.green * b.green, a.blue * b.blue);
}

fn times(a: Lights, b: Rows) -> Lights {
    return Lights(a.red * b, a.green * b, a.blue * b);
}

fn plus(a: Lights, b: Lights) -> Lights {
    return Lights(a.red + b.red, a.green + b.green, a.blue + b.blue);
}

fn minus(a: Lights, b: Lights) -> Lights {
    return Lights(a.red - b.red, a.green - b.green, a.blue - b.blue);
}

fn quotient(a: Lights, b: Lights, least: f32) -> Lights {
    return Lights(
        a.red / max(b.red, Rows(least)),
        a.green / max(b.green, Rows(least)),
        a.blue / max(b.blue, Rows(least)),
    );
}

fn selected(a: Lights, b: Lights, is: RowIs) -> Lights {
    return Lights(select(a.red, b.red, is), select(a.green, b.green, is), select(a.blue, b.blue, is));
}

// The largest difference in any channel.
fn difference(a: Lights, b: Lights) -> Rows {
    return max(max(abs(a.red - b.red), abs(a.green - b.green)), abs(a.blue - b.blue));
}

fn fixed(depth: Rows) -> RowBits {
    return clamp(RowBits(round(depth * DEPTHS)), RowBits(1u), RowBits(65535u));
}

fn encode(v: Rows) -> RowBits {
    if HAS_GAIN {
        var bits = RowBits(0u);
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            bits = with_bits(bits, i, pack2x16float(vec2(row(v, i), 0.0)));
        }
        return bits;
    }
    // Only a late hit may brighten the light behind it past white.
    let most = select(3.4e38, 1.0, HAS_OVER || HAS_VOLUMES);
    return RowBits(round(min(v, Rows(most)) * 65535.0));
}

// Like `decode`, in fixed-point steps.
fn level(bits: RowBits) -> Rows {
    if HAS_GAIN {
        var v = Rows(0.0);
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            v = with_row(v, i, unpack2x16float(row_bits(bits, i)).x);
        }
        return v;
    }
    return Rows(bits);
}

fn decode(bits: RowBits) -> Rows {
    return level(bits) * select(1.0 / 65535.0, 1.0, HAS_GAIN);
}
