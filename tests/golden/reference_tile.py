"""Sections 7 and 8 of docs/wire-format.md: tiles of depth streams."""
from reference_coder import bad_unless, head, pixels_of
from reference_flat import FlatBlock
from reference_runs import run_tile
from reference_tables import quot


# 7
class Block:
    any = full = flat = corrected = first = second = 0
    plane = surface = None
    uniform = 1


class Pixel:
    level = correction = surface_miss = neighbour_miss = choice = 0


NO_PIXEL = Pixel()


def activity_of(table, total, half):
    while half > 15:
        half, total = half >> 1, total >> 1
    return table[half][min(total, 255)]


def coefficient(coder, shift):
    length = coder.raw(5)
    if length == 0:
        return 0
    bad_unless(length + shift <= 30)
    negative = coder.raw(1)
    m = coder.raw(length - 16) if length > 16 else 0
    low = min(length, 16)
    m = (m << low) + coder.raw(low)
    return -(m << shift) if negative else m << shift


class DepthTile:
    codes_corrected = True

    def __init__(self, stream, coder, models, depth):
        self.s, self.c, self.m, self.depth = stream, coder, models, depth
        self.surfaces_kind = stream.key["tolerance"] == 3
        self.lossless = stream.key["tolerance"] == 0

    def begin(self, mixed):
        """Mixed tiles (section 7.5) are in reference_mix.py."""

    def decode(self):
        c, s = self.c, self.s
        verbatim, bx, by, bw, bh = head(c, s)
        self.begin(s.mixed)
        self.us, self.vs = pixels_of(s, bx, by, bw, bh)
        if verbatim and c.raw(1):
            return run_tile(self)
        if verbatim:
            for v in self.vs:
                for u in self.us:
                    self.depth[v * s.width + u] = c.raw(16)
            return
        self.fallback = max(1, s.levels.nearest(c.raw(16)))
        self.n = c.raw(6)
        shift = c.raw(5) if self.n else 0
        self.surfaces = [None] + [tuple(coefficient(c, shift) for _ in range(6 if c.raw(1) else 3))
                                  for _ in range(self.n)]
        self.blocks, self.pixels = {}, {}
        self.last_middle = 256 * self.fallback
        for y in range(by, by + bh):
            for x in range(bx, bx + bw):
                self.block(x, y)
            for v in range(y * 8, min(y * 8 + 8, s.height)):
                for u in self.us:
                    self.pixel(u, v)

    # 7.1
    def block(self, x, y):
        c, m, b = self.c, self.m, Block()
        left, above = self.blocks.get((x - 1, y)), self.blocks.get((x, y - 1))
        corner = self.blocks.get((x - 1, y - 1))
        self.blocks[x, y] = b

        def pair(what):
            return 3 * (getattr(left, what) if left else 2) + (getattr(above, what) if above else 2)

        b.any = c.bit(m.block_any[pair("any")])
        if not b.any:
            if left:
                b.first, b.second = left.first, left.second
            return
        b.full = c.bit(m.block_full[pair("full")])
        if self.n:
            fl, fa, fc = (n.first if n else 0 for n in (left, above, corner))
            ctx = (fl == fa) + 2 * (fa == fc)
            if c.bit(m.label_as_left[ctx]):
                b.first = fl
            elif fa != fl and c.bit(m.label_as_above[ctx]):
                b.first = fa
            else:
                b.first = c.tree(m.label_index, 6)
            if self.surfaces_kind and b.first:
                if c.bit(m.block_second[0]):
                    b.second = c.tree(m.label_index, 6)
                b.uniform = c.bit(m.block_uniform[int(b.second != 0)])
            bad_unless(b.first <= self.n and b.second <= self.n)
        if b.first:
            b.surface = self.surface_in_block(self.surfaces[b.first], x, y)
        if not self.lossless and (not self.surfaces_kind or not b.first):
            b.flat = c.bit(m.block_flat[9 * (b.first != 0) + pair("flat")])
            if b.flat:
                b.plane = FlatBlock(self, x, y).read()
                self.last_middle = b.plane[0]
                return
        if self.codes_corrected and (not self.surfaces_kind or not b.first or not b.uniform):
            b.corrected = c.bit(m.block_corrected[9 * (b.first != 0) + pair("corrected")])

    def inverse_depth(self, surface, u, v):
        x, y = self.s.rays[v * self.s.width + u]
        plane = ((surface[0] * x + surface[1] * y) >> 27) + surface[2]
        if len(surface) == 3:
            return plane
        x, y = x >> 6, y >> 6
        products = ((x * x) >> 20, (x * y) >> 20, (y * y) >> 20)
        return plane + (sum(k * p for k, p in zip(surface[3:], products)) >> 22)

    # 8
    def surface_in_block(self, surface, bx, by):
        u0, v0 = bx * 8, by * 8
        u1, v1 = min(u0 + 7, self.s.width - 1), min(v0 + 7, self.s.height - 1)
        um, vm = (u0 + u1) >> 1, (v0 + v1) >> 1

        def q(u, v):
            return self.s.levels.level_q8(self.inverse_depth(surface, u, v))

        dx = quot(q(u1, vm) - q(u0, vm), u1 - u0) if u1 > u0 else 0
        dy = quot(q(um, v1) - q(um, v0), v1 - v0) if v1 > v0 else 0
        return q(um, vm) - dx * um - dy * vm, dx, dy

    # 7.2
    def pixel(self, u, v):
        self.plain_pixel(u, v)

    def plain_pixel(self, u, v):
        at = self.pixels.get
        b, m = self.blocks[u // 8, v // 8], self.m
        if not b.any:
            return
        l, up = at((u - 1, v), NO_PIXEL), at((u, v - 1), NO_PIXEL)
        ul, ur = at((u - 1, v - 1), NO_PIXEL), at((u + 1, v - 1), NO_PIXEL)
        ll, uu = at((u - 2, v), NO_PIXEL), at((u, v - 2), NO_PIXEL)
        urr, ull = at((u + 2, v - 1), NO_PIXEL), at((u - 2, v - 1), NO_PIXEL)
        if not b.full:
            ctx = sum((p.level != 0) << i for i, p in enumerate((l, up, ul, ur, ll, uu, urr, ull)))
            if not self.c.bit(m.mask[ctx]):
                return
        p = Pixel()
        self.pixels[u, v] = p
        count = self.on_plane(b, p, u, v) or self.on_surface(b, p, u, v, (l.choice * 3 + up.choice) * 3 + ul.choice)
        if not count:
            count = self.predicted(b, p, u, v, (l, up, ur, ul, ll, uu))
        self.depth[v * self.s.width + u] = count

    def on_plane(self, b, p, u, v):
        if not b.flat:
            return 0
        m, dx, dy = b.plane
        q = m - ((7 * (dx + dy)) >> 1) + dx * (u % 8) + dy * (v % 8)
        p.level = self.fallback = min(max((q + 128) >> 8, 1), self.s.levels.last)
        return self.s.levels.depth[p.level]

    def on_surface(self, b, p, u, v, ctx):
        if not self.surfaces_kind or not b.first:
            return 0
        p.choice = 1
        if not b.uniform:
            p.choice = self.c.bit(self.m.on_surface[ctx])
            if not p.choice and b.second:
                p.choice = 2 * self.c.bit(self.m.on_surface[27 + ctx])
        if not p.choice:
            return 0
        iv = self.inverse_depth(self.surfaces[b.first if p.choice == 1 else b.second], u, v)
        count = 0 if iv < 32768 else ((1 << 32) // iv + 1) >> 1
        bad_unless(0 < count <= 65535)
        p.level = self.s.levels.nearest(count)
        self.fallback = max(1, p.level)
        return count

    def predicted(self, b, p, u, v, around):
        c, m, levels = self.c, self.m, self.s.levels
        l, up, ur, ul = around[:4]
        last = levels.last
        halves = self.s.bounds.halves(u // 8, v // 8)
        if l.level and up.level and ul.level:
            near = sorted((l.level, up.level, l.level + up.level - ul.level))[1]
            if self.lossless and levels.every_count and ur.level:
                apart = sum(abs(a.level - b.level) for a, b in ((l, ul), (up, ul), (up, ur)))
                if 2 <= apart <= 60:
                    mean = (6 * l.level + 5 * up.level + 2 * ur.level - 5 * ul.level + 4) >> 3
                    near = min(max(mean, 1), last)
        else:
            near = next((n.level for n in around if n.level), self.fallback)
        surface, side = near, 0
        if b.first:
            origin, dx, dy = b.surface
            q = origin + dx * u + dy * v
            q4 = origin + dx * (u // 8 * 8 + 4) + dy * (v // 8 * 8 + 4)
            reach = halves[min(max((q4 + 128) >> 8, 1), last)]
            total = weight = 0
            for n, w, expected in ((l, 4, q - dx), (up, 4, q - dy), (ul, 1, q - dx - dy),
                                   (ur, 2, q + dx - dy)):
                off = 256 * n.level - expected
                if n.level and abs(off) <= 256 * (12 + 3 * reach):
                    total, weight = total + w * off, weight + w
            drift = (total * self.s.drift[weight]) >> 16
            surface = min(max((q + drift + 128) >> 8, 1), last)
            miss = [2 * getattr(l, k) + 2 * getattr(up, k) + getattr(ul, k) + getattr(ur, k)
                    for k in ("surface_miss", "neighbour_miss")]
            side = int(not any(n.level for n in (l, up, ul, ur)) or
                       miss[0] <= miss[1] + 2 * (2 + reach))
        level = prediction = surface if side else near
        half = halves[prediction]
        count = None
        if b.corrected and self.lossless:
            level, count = self.residual(prediction, around)
            p.correction = min(max(level - prediction, -8), 8)
        elif b.corrected:
            level, p.correction, count = self.correct(prediction, half, side, l, up, ul, ur)
        bad_unless(1 <= level <= last)
        p.level = self.fallback = level
        p.surface_miss = min(100, abs(level - surface))
        p.neighbour_miss = min(100, abs(level - near))
        return levels.depth[level] if count is None else count

    def correct(self, prediction, half, side, l, up, ul, ur):
        c, m = self.c, self.m
        total = sum(abs(a.level - b.level) if a.level and b.level else half + 3
                    for a, b in ((l, ul), (up, ul), (up, ur)))
        row = 8 * side + activity_of(self.s.activity, total, half)
        ml, mu, mul, mur = (min(2, abs(n.correction)) for n in (l, up, ul, ur))
        if not c.bit(m.correction[row * 81 + 27 * ml + 9 * mu + 3 * mul + mur]):
            return prediction, 0, None
        lean = (prediction < l.level) - (prediction > l.level) + 1
        sl, su = ((n.correction > 0) - (n.correction < 0) + 1 for n in (l, up))
        sign = 1 if c.bit(m.sign[27 * side + 9 * lean + 3 * sl + su]) else -1
        unary = (row * 3 + (2 if ml + mu > 2 else int(ml + mu > 0))) * 12
        more = 0
        while more < 12 and c.bit(m.magnitude[unary + more]):
            more += 1
        kept = min(max(sign * (more + 1), -2), 2)
        if more < 12:
            return prediction + sign * (more + 1) * (half + half // 2 + 1), kept, None
        level, count = self.jump(prediction, sign)
        return level, kept, count

    def jump(self, prediction, sign):
        c = self.c
        length = c.tree(self.m.jump_length, 5)
        if length == 0:
            count = c.raw(16)
            bad_unless(count)
            return max(1, self.s.levels.nearest(count)), count
        bad_unless(length <= 16)
        distance = 2 + c.bit(self.m.jump_top[length]) if length > 1 else 1
        if length > 2:
            distance = (distance << (length - 2)) + c.raw(length - 2)
        return prediction + sign * distance, None

    # 7.4
    def residual(self, prediction, around):
        l, up, ur, ul, ll, uu = around
        total = sum(abs(a.level - b.level) if a.level and b.level else 3
                    for a, b in ((l, ul), (up, ul), (up, ur)))

        def grade(a, b):
            d = a.level - b.level if a.level and b.level else 0
            size = (0, 1, 2, 2, 3)[min(abs(d), 4)]
            return size if d >= 0 else -size

        def size(n):
            return abs(n.correction)

        sl, su = ((n.correction > 0) - (n.correction < 0) for n in (l, up))
        tilt = (prediction < l.level) - (prediction > l.level)
        lean = 9 * tilt + 3 * sl + su
        slopes = 49 * grade(l, ul) + 7 * grade(up, ul) + grade(ur, up)
        shape = 514 + (3 * slopes + tilt) * (1 if lean >= 0 else -1)
        shape += 1029 * ((size(l) + size(up) > 0) + (size(l) + size(up) > 2))
        every = int(self.s.levels.every_count)
        models = [getattr(self.m, f"shape{every}")[shape]]
        if every:
            e = 2 * size(l) + 2 * size(up) + size(ul) + size(ur) + size(ll) + size(uu)
            bits = e.bit_length()
            energy = min(e if e < 4 else 2 * bits - 2 + (e >> (bits - 2) & 1), 11)
            row = (14 * energy + abs(lean)) * 3 + (total > 1) + (total > 4)
            models.append(self.m.errors1[row])
        symbol = self.c.symbol(*models)
        if symbol == 15:
            return self.jump(prediction, -1 if self.c.raw(1) else 1)
        size = (symbol + 1) // 2
        if size > 4:
            bits = size - 4
            size = 3 + (1 << bits) + self.c.raw(bits)
        return prediction + (size if (symbol % 2 == 1) == (lean >= 0) else -size), None


def depth_tile(stream, coder, models, depth):
    DepthTile(stream, coder, models, depth).decode()
