"""Sections 3 and 10 of docs/wire-format.md: rays, levels, bounds and regeneration."""
import math
import struct


def div(a, b):
    return (2 * a + b) // (2 * b)


def quot(a, b):
    return a // b if (a < 0) == (b < 0) else -(-a // b)


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def bits32(value):
    return struct.unpack("<I", struct.pack("<f", value))[0]


# 3.1
def rays_of(key):
    """(x, y) in Q27 of every pixel, row by row."""
    lens = [key[name] << 6 for name in ("k1", "k2", "p1", "p2", "k3")]
    plain = not any(lens)
    bits = 27 if plain else 30
    xs = [div((65536 * u - key["cx"]) << bits, key["fx"]) for u in range(key["width"])]
    ys = [div((65536 * v - key["cy"]) << bits, key["fy"]) for v in range(key["height"])]
    if plain:
        return [(x, y) for y in ys for x in xs]
    return [undistort(x, y, *lens) for y in ys for x in xs]


def mul(a, b):
    return (a * b) >> 30


def undistort(tx, ty, k1, k2, p1, p2, k3):
    one = 1 << 30

    def project(x, y):
        x2, y2, xy = mul(x, x), mul(y, y), mul(x, y)
        r2 = x2 + y2
        radial = one + mul(r2, k1 + mul(r2, k2 + mul(r2, k3)))
        slope = k1 + mul(r2, 2 * k2 + mul(r2, 3 * k3))
        p1x, p1y, p2x, p2y = mul(p1, x), mul(p1, y), mul(p2, x), mul(p2, y)
        out = (mul(x, radial) + 2 * mul(p1, xy) + mul(p2, r2 + 2 * x2),
               mul(y, radial) + mul(p1, r2 + 2 * y2) + 2 * mul(p2, xy),
               radial + 2 * mul(x2, slope) + 2 * p1y + 6 * p2x,
               2 * mul(xy, slope) + 2 * p1x + 2 * p2y,
               radial + 2 * mul(y2, slope) + 6 * p1y + 2 * p2x)
        det = (out[2] * out[4] - out[3] * out[3]) >> 30
        if max(map(abs, out)) >= 1 << 42 or det < 1 << 20:
            raise ValueError("lens")
        return out + (det,)

    x, y = tx, ty
    for _ in range(20):
        px, py, xx, xy, yy, det = project(x, y)
        ex, ey = tx - px, ty - py
        dx, dy = quot(yy * ex - xy * ey, det), quot(xx * ey - xy * ex, det)
        x, y = x + dx, y + dy
        if dx == 0 and dy == 0:
            break
    px, py = project(x, y)[:2]
    if max(abs(tx - px), abs(ty - py)) > 1 << 10:
        raise ValueError("lens")
    return (x + 4) >> 3, (y + 4) >> 3


# 3.2
class Levels:
    def __init__(self, key):
        self.c8, self.offset = key["lattice"], key["offset"]
        self.every_count = self.c8 == 0
        self.dense = math.isqrt(self.c8 >> 8) if self.c8 else 65535
        self.depth = list(range(self.dense + 1))
        self.k_last = 0
        rounding = 0 if key["flags"] & 4 else 128
        for k in range((self.c8 >> 8) // self.dense + 1 if self.c8 else 0, 0, -1):
            d = (((self.c8 << 16) // ((k << 16) + self.offset)) + rounding) >> 8
            if d <= self.depth[-1]:
                continue
            if d > 65535:
                break
            self.depth.append(d)
            self.k_last = k
        self.last = len(self.depth) - 1
        self.nearest_of = [0] * 65536
        level = 1
        for d in range(1, 65536):
            while level < self.last and self.depth[level + 1] - d <= d - self.depth[level]:
                level += 1
            self.nearest_of[d] = level

    def nearest(self, d):
        return self.nearest_of[d]

    def level_q8(self, iv):
        iv = max(iv, 1)
        d = (1 << 39) // iv
        if self.k_last and d > 256 * self.dense:
            d = 256 * self.last + 256 * self.k_last + (self.offset >> 8) - ((self.c8 * iv) >> 31)
        return min(max(d, 256), 256 * self.last)


# 3.3
class Bounds:
    def __init__(self, key, rays, levels):
        self.key, self.levels, self.cache = key, levels, {}
        self.wide, self.high = (key["width"] + 7) // 8, (key["height"] + 7) // 8
        lengths = [self.block_length(rays, bx, by)
                   for by in range(self.high) for bx in range(self.wide)]
        span = max(lengths) - 65536 + 1
        self.classes = [(length - 65536) * 16 // span for length in lengths]
        self.inverse = [(1 << 32) // (65536 + -(-span * (c + 1) // 16)) for c in range(16)]

    def block_length(self, rays, bx, by):
        width, height = self.key["width"], self.key["height"]
        u1, v1 = min(bx * 8 + 8, width) - 1, min(by * 8 + 8, height) - 1
        most = 65536
        for v in range(by * 8, v1 + 1):
            for u in range(bx * 8, u1 + 1):
                if u in (bx * 8, u1) or v in (by * 8, v1):
                    x, y = rays[v * width + u]
                    square = x * x + y * y + (1 << 54)
                    root = math.isqrt(square)
                    root += root * root < square
                    most = max(most, (root + 2047) >> 11)
        return most

    def error_q8(self, d):
        key, unit = self.key, self.key["unit"]
        if key["tolerance"] == 0:
            return 0
        if key["tolerance"] == 1:
            error = key["bound"] * 10**5 * 256 // unit
        else:
            sigma = 0
            if key["noise"] == 2:
                sigma = key["s"] * 256000 // unit
            if key["noise"] == 1:
                z = min(d * unit // 10**6, 1 << 27)
                sigma = ((z * z) >> 12) * key["s"] // 1000 // 1000 * 1048 // unit
            error = (min(sigma, 1 << 31) * key["sigmas"]) >> 16
        slack = 1 + (d >> 12)
        return 0 if error <= slack else min(error - slack, 65535 * 256)

    def halves(self, bx, by):
        """half(l) of the block's class, for all levels."""
        c = self.classes[by * self.wide + bx]
        if c not in self.cache:
            depth, last, out = self.levels.depth, self.levels.last, [0]
            reach = 1
            for level in range(1, last + 1):
                limit = depth[level] + ((self.error_q8(depth[level]) * self.inverse[c]) >> 24)
                reach = max(reach, level)
                while reach < last and depth[reach + 1] <= limit:
                    reach += 1
                out.append(0 if self.key["tolerance"] == 0 else min(reach - level, 255))
            self.cache[c] = out
        return self.cache[c]


# 10
def z_of_count(key, count):
    unit = key["unit"] / 1e12
    if key["z_rule"] == 0:
        return float32(count * unit)
    v = float32(float(count) * float32(unit))
    if key["z_rule"] == 1:
        return v
    s, t = 1e6, v
    while t >= 10.0:
        t, s = t / 10.0, s / 10.0
    t = v
    while t < 1.0 and s < 1e12:
        t, s = t * 10.0, s * 10.0
    return float32(round(v * s) / s)


def regenerate_table(key):
    """A function of (ray, z) that gives the bits of a point."""
    w, a, b, c = (key[n] * 2.0**-30 for n in ("aw", "ax", "ay", "az"))
    t = [key[n] * 1e-6 for n in ("atx", "aty", "atz")]
    mirror = key["flags"] & 8
    optical = (w, a, b, c) == (1.0, 0.0, 0.0, 0.0) and not any(t) and not mirror
    m = ((1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)),
         (2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)),
         (2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)))

    def point(ray, z):
        x, y = ray[0] * 2.0**-27 * z, ray[1] * 2.0**-27 * z
        if optical:
            return bits32(x), bits32(y), bits32(z)
        if mirror:
            y = -y
        return tuple(bits32(row[0] * x + row[1] * y + row[2] * z + t[i]) for i, row in enumerate(m))

    return point
