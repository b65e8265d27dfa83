"""Section 7.3 of docs/wire-format.md: the plane of a flat block."""
from reference_tables import quot


def beyond(plane, x, y):
    return plane[0] + 8 * (x * plane[1] + y * plane[2])


class FlatBlock:
    def __init__(self, tile, x, y):
        self.t, self.x, self.y = tile, x, y
        self.last = tile.s.levels.last
        self.halves = tile.s.bounds.halves(x, y)

        def plane_at(dx, dy):
            block = tile.blocks.get((x + dx, y + dy))
            return block.plane if block and block.flat else None

        self.l, self.a = plane_at(-1, 0), plane_at(0, -1)
        self.al, self.ar = plane_at(-1, -1), plane_at(1, -1)
        pixels = [tile.pixels.get((8 * x + i, 8 * y - 1)) for i in range(8)]
        self.above8 = 32 * sum(p.level for p in pixels) if all(pixels) else None
        self.block = tile.blocks[x, y]

    def kept(self, middle, dx, dy):
        steep = 1 << 18
        return (min(max(middle, 256), 256 * self.last), min(max(dx, -steep), steep),
                min(max(dy, -steep), steep))

    def on_surface(self):
        origin, dx, dy = self.block.surface
        origin += dx * 8 * self.x + dy * 8 * self.y
        s = self.kept(origin + ((7 * (dx + dy)) >> 1), dx, dy)
        limit = 256 * (12 + 3 * self.halves[min(max((s[0] + 128) >> 8, 1), self.last)])
        draws = [(p[0] - beyond(s, *at), weight) for p, at, weight in
                 ((self.l, (-1, 0), 2), (self.a, (0, -1), 2), (self.al, (-1, -1), 1),
                  (self.ar, (1, -1), 1)) if p]
        if not self.a and self.above8 is not None:
            draws.append((self.above8 - (s[0] - ((9 * s[2]) >> 1)), 2))
        draws = [(off, weight) for off, weight in draws if abs(off) <= limit]
        weight = sum(w for _, w in draws)
        drift = quot(sum(off * w for off, w in draws), weight) if weight else 0
        return s[0] + drift, s[1], s[2]

    def foretold(self):
        if self.block.first:
            return self.kept(*self.on_surface())
        left, above = self.l, self.a
        if left and above:
            return self.kept((beyond(left, 1, 0) + beyond(above, 0, 1)) >> 1,
                             (left[1] + above[1]) >> 1, (left[2] + above[2]) >> 1)
        for plane, at in ((left, (1, 0)), (above, (0, 1))):
            if plane:
                return self.kept(beyond(plane, *at), *plane[1:])
        if self.above8 is not None:
            return self.kept(self.above8, 0, 0)
        for plane, at in ((self.al, (1, 1)), (self.ar, (-1, 1))):
            if plane:
                return self.kept(beyond(plane, *at), *plane[1:])
        return self.kept(self.t.last_middle, 0, 0)

    def steps(self, kind, ctx):
        c, m = self.t.c, self.t.m
        length, unary = 0, (kind * 6 + ctx) * 13
        while length < 12 and c.bit(m.plane_length[unary + length]):
            length += 1
        if length == 0:
            return 0
        negative = c.bit(m.plane_sign[kind])
        n = 2 + c.bit(m.plane_top[kind * 13 + length]) if length > 1 else 1
        if length > 2:
            n = (n << (length - 2)) + c.raw(length - 2)
        return -n if negative else n

    def read(self):
        f = self.foretold()
        t = 2 * self.halves[(f[0] + 128) >> 8] + 1
        on = 3 * (self.block.first != 0)
        o = self.steps(0, bool(self.l) + bool(self.a) + on)
        gx = self.steps(1, (o != 0) + on)
        gy = self.steps(2, (gx != 0) + on)
        return self.kept(f[0] + 64 * t * o, f[1] + 16 * t * gx, f[2] + 16 * t * gy)
