"""Section 9 of docs/wire-format.md: tiles of raw clouds."""
import math
import struct

from reference_coder import bad_unless, fresh, head, pixels_of


# 9
def ordered(bits):
    return bits ^ 0xFFFFFFFF if bits >> 31 else bits | 0x80000000


def unordered(value):
    return value & 0x7FFFFFFF if value >> 31 else value ^ 0xFFFFFFFF


MOST = struct.unpack("<f", b"\xff\xff\x7f\x7f")[0]


def near(value):
    value = -MOST if not value > -MOST else MOST if not value < MOST else value
    return ordered(struct.unpack("<I", struct.pack("<f", value))[0])


def divide(a, b):
    """IEEE division, which Python refuses by zero."""
    if b != 0:
        return a / b
    return math.nan if a == 0 or a != a else math.copysign(math.inf, a) * math.copysign(1, b)


class RawPoint:
    def __init__(self):
        self.at, self.step, self.miss, self.size = [0x80000000] * 3, 0, [0.0, 0.0], [0] * 4

    def value(self, axis):
        return struct.unpack("<f", struct.pack("<I", unordered(self.at[axis])))[0]


class RawTile:
    def __init__(self, stream, coder, cloud):
        self.s, self.c, self.cloud = stream, coder, cloud
        self.mask = fresh(64)
        self.size = [[fresh(64) for _ in range(12)] for _ in range(4)]
        self.sign = [fresh(9) for _ in range(4)]
        self.top = [[fresh(4) for _ in range(33)] for _ in range(4)]
        self.points, self.last = {}, RawPoint()

    def number(self):
        value = struct.unpack("<d", struct.pack("<Q", sum(self.c.raw(16) << n for n in (48, 32, 16))))[0]
        bad_unless(math.isfinite(value))
        return value

    def decode(self):
        c, s = self.c, self.s
        verbatim, *rect = head(c, s)
        us, vs = pixels_of(s, *rect)
        if not verbatim:
            self.present, self.primary = c.raw(1), c.raw(2)
            bad_unless(self.primary < 3)
            self.slope, self.ratio, self.steps = [0.0] * 2, [[0.0] * 3] * 2, 0
            if self.present:
                self.slope = [self.number() for _ in range(2)]
                self.ratio = [[self.number() for _ in range(3)] for _ in range(2)]
                self.steps = c.raw(2)
                bad_unless(self.steps < 3)
                if self.steps:
                    self.origin, self.step = self.number(), self.number()
            self.cost = [[0 if self.present else 1 << 20, 0, 0, 0] for _ in range(2)]
        for v in vs:
            for u in us:
                bits = self.words() if verbatim else self.point(u, v)
                if bits and all((w & 0x7F800000) != 0x7F800000 for w in bits):
                    self.cloud[v * s.width + u] = bits

    def words(self):
        return tuple(self.c.raw(16) << 16 | self.c.raw(16) for _ in range(3))

    def median(self, get):
        l, up, ul, ur = self.around[:4]
        if l and up:
            a, b = get(l), get(up)
            return min(max(a + b - get(ul), min(a, b)), max(a, b)) if ul else (a + b) >> 1
        return get(l or up or ur or self.last)

    def point(self, u, v):
        get = self.points.get
        l, ll, ul = get((u - 1, v)), get((u - 2, v)), get((u - 1, v - 1))
        up, ur, urr = get((u, v - 1)), get((u + 1, v - 1)), get((u + 2, v - 1))
        ctx = sum((n is not None) << i for i, n in enumerate((l, ll, ul, up, ur, urr)))
        if not self.c.bit(self.mask[ctx]):
            return None
        self.around, p, a = (l, up, ul, ur), RawPoint(), self.primary
        px, py = u - 0.5 * self.s.width, v - 0.5 * self.s.height
        scale = 1.0 + self.slope[0] * px + self.slope[1] * py
        if self.steps:
            p.step = self.residual(p, 3, self.median(lambda n: n.step))
            bad_unless(abs(p.step) <= 1 << 28)
            s = self.origin + self.step * p.step
            first = near(scale * s if self.steps == 1 else divide(scale, s))
        else:
            first = self.median(lambda n: n.at[a])
        self.coordinate(p, 0, a, first)
        for i, axis in enumerate([n for n in range(3) if n != a]):
            self.other(p, i, axis, px, py, scale)
        self.points[u, v] = self.last = p
        return tuple(unordered(n) for n in p.at)

    def coordinate(self, p, kind, axis, predicted):
        value = self.residual(p, kind, predicted)
        bad_unless(0 <= value < 1 << 32)
        p.at[axis] = value
        bad_unless(math.isfinite(p.value(axis)))

    def other(self, p, i, axis, px, py, scale):
        l, up, ul, _ = self.around
        main, q = p.value(self.primary), self.ratio[i]
        r = divide(q[0] * px + q[1] * py + q[2], scale) if self.present else 0.0
        mean = slanted = 0.0
        if l and up:
            mean = 0.5 * (l.miss[i] + up.miss[i])
            slanted = l.miss[i] + up.miss[i] - ul.miss[i] if ul else mean
        elif l or up:
            mean = slanted = (l or up).miss[i]
        candidates = [near(main * r), near(main * (r + mean)), near(main * (r + slanted)),
                      self.median(lambda n: n.at[axis])]
        best = self.cost[i].index(min(self.cost[i]))
        self.coordinate(p, 1 + i, axis, candidates[best])
        p.miss[i] = p.value(axis) / main - r if main != 0 else 0.0
        for k, candidate in enumerate(candidates):
            cost = self.cost[i][k]
            length = abs(p.at[axis] - candidate).bit_length()
            self.cost[i][k] = (cost + 32 * length - cost // 16) & 0xFFFFFFFF

    def residual(self, p, kind, predicted):
        c, (l, up) = self.c, self.around[:2]
        sl, su = l.size[kind] if l else 0, up.size[kind] if up else 0
        total = abs(sl) + abs(su)
        ctx = sum(limit < total for limit in (0, 1, 2, 4, 6, 9, 13, 18, 24, 32, 42))
        length = c.tree(self.size[kind][ctx], 6)
        if length == 0:
            return predicted
        sgn = (sl > 0) - (sl < 0) + 3 * ((su > 0) - (su < 0)) + 4
        below = c.bit(self.sign[kind][sgn])
        p.size[kind] = -length if below else length
        models = self.top[kind][min(length, 32)]
        m, rest, node = 1, min(length, 32) - 1, 1
        for _ in range(2):
            if rest > 0:
                rest -= 1
                bit = c.bit(models[node])
                m, node = 2 * m + bit, 2 * node + bit
        if rest > 16:
            m, rest = (m << (rest - 16)) + c.raw(rest - 16), 16
        if rest:
            m = (m << rest) + c.raw(rest)
        bad_unless(length <= 32)
        return predicted - m if below else predicted + m


def raw_tile(stream, coder, cloud):
    RawTile(stream, coder, cloud).decode()
