"""Sections 5.1, 7.5 and 8.1 of docs/wire-format.md: tiles of streams with effort_best."""
from reference_coder import bad_unless
from reference_points import STRETCH, rate, squash
from reference_tables import quot
from reference_tile import DepthTile

PIXEL_SIZES = (96, 96, 147, 225, 150, 128, 729, 125)
MASK_SIZES = (256, 4096, 256, 1024, 512)
SLOTS, MIXERS = 9, 12


class Pixel:
    level = error = choice = 0
    misses = (0,) * 8


NO_PIXEL = Pixel()


def clamp(v, low, high):
    return min(max(v, low), high)


def lim(v, n):
    return clamp(v, -n, n) + n


def graded(v):
    size = abs(v)
    grade = size if size < 2 else 2 if size < 4 else 3
    return 3 + (grade if v > 0 else -grade)


def log_class(v, n):
    if v < 4:
        return min(v, n)
    length = v.bit_length()
    return min(2 * length - 2 + ((v >> (length - 2)) & 1), n)


# 5.1
def mixed(coder, models, weights):
    """`weights`: the weights, then their count of uses."""
    odds = [(STRETCH[(m[0] + m[1]) >> 5] * (256 * (2 * m[2] + 1) // (2 * m[2] + 3))) >> 8 for m in models]
    x = clamp(sum(w * s for w, s in zip(weights, odds)) >> 16, -2047, 2047)
    p = clamp(squash(x), 32, 65504)
    split = (coder.range >> 16) * p
    one = coder.code < split
    coder.range = split if one else coder.range - split
    coder.code -= 0 if one else split
    coder.normalise()
    uses = weights[-1]
    r = 13 if uses < 64 else 14 if uses < 1024 else 15
    error = 65536 * one - p
    for i, s in enumerate(odds):
        weights[i] = clamp(weights[i] + ((s * error + (1 << (r - 1))) >> r), -(1 << 19), 1 << 19)
    weights[-1] = min(uses + 1, 1024)
    for m in models:
        fast, slow = rate(min(m[2], 14)), rate(m[2])
        m[0] += ((65535 * one - m[0]) * fast) >> 16
        m[1] += ((65535 * one - m[1]) * slow) >> 16
        m[2] = min(m[2] + 1, 150)
    return int(one)


class MixTile(DepthTile):
    """A tile of an effort_best stream, which says for itself whether it is mixed."""

    def begin(self, mixed):
        self.mixed, self.codes_corrected, self.bias = mixed, not mixed, [0] * 512

    def pixel(self, u, v):
        if self.mixed:
            self.mixed_pixel(u, v)
        else:
            self.plain_pixel(u, v)

    # 7.5
    def mixed_pixel(self, u, v):
        b = self.blocks[u // 8, v // 8]
        if not b.any:
            return
        if not b.full and not self.mask(u, v):
            return
        p = Pixel()
        self.pixels[u, v] = p

        def at(dx, dy):
            return self.pixels.get((u + dx, v + dy), NO_PIXEL)

        ctx = (at(-1, 0).choice * 3 + at(0, -1).choice) * 3 + at(-1, -1).choice
        count = self.on_plane(b, p, u, v) or self.on_surface(b, p, u, v, ctx)
        self.depth[v * self.s.width + u] = count or self.blended(b, p, u, v, at)

    def mask(self, u, v):
        first = 8 * (self.us[0] // 8)

        def there(dx, dy):
            return int((u + dx, v + dy) in self.pixels)

        def h(i): return there(i, 0)
        def a(i): return there(i, -1)
        def b(i): return there(i, -2)
        near = (h(-1) + 2 * a(0) + 4 * a(-1) + 8 * a(1) + 16 * h(-2) + 32 * b(0) + 64 * a(2) + 128 * a(-2))
        run = 1
        while run < 15 and run < u - first + 4 and h(-1 - run) == h(-1):
            run += 1
        ahead = next((i for i in (1, 2, 3) if a(i) != a(0)), 4)
        behind = next((i for i in (1, 2, 3) if a(-i) != a(0)), 4)
        block = self.blocks.get((u // 8 + 1, v // 8))
        right = 2 if block is None else 0 if not block.any else 3 if block.full else 1
        contexts = (near, near + 256 * h(-3) + 512 * b(-1) + 1024 * b(1) + 2048 * a(3),
                    16 * run + 4 * (ahead - 1) + 2 * h(-1) + a(0),
                    128 * (u % 8) + 4 * (near & 15) + right + 64 * b(0),
                    32 * (4 * (behind - 1) + ahead - 1) + h(-1) + 2 * a(0) + 4 * b(0) + 8 * b(-1) + 16 * b(1))
        models = [self.m.mix_mask[sum(MASK_SIZES[:i]) + c] for i, c in enumerate(contexts)]
        return mixed(self.c, models, self.m.mix_mask_weights[near & 15])

    # 8.1
    def blend(self, b, u, v, at):
        last = self.s.levels.last
        around = [at(*d).level for d in ((-1, 0), (0, -1), (1, -1), (-1, -1), (-2, 0), (0, -2))]
        l, up, ur, ul, ll, uu = around
        first = next((n for n in around if n), self.fallback)
        l, up = l or first, up or first
        ul, ur, uu, ll = ul or up, ur or up, uu or up, ll or l
        self.levels = l, up, ul, ur, ll, uu
        c = [4 * clamp(l + up - ul, min(l, up), max(l, up)), 4 * (l + up - ul), 4 * l, 4 * up,
             2 * (l + up) + ur - ul, 4 * (l + ur - up), 4 * (2 * up - uu),
             self.drawn(b, u, v, at) >> 6 if b.first else l + up + ur + ul]
        missed = [2 * (at(-1, 0).misses[i] + at(0, -1).misses[i]) + at(-1, -1).misses[i] + at(1, -1).misses[i]
                  for i in range(8)]
        weights = [(1 << 24) // (m + 4) ** 2 for m in missed]
        self.off = min(missed)
        plain = clamp(quot(64 * sum(w * k for w, k in zip(weights, c)), sum(weights)), 256, 256 * last)
        kind = sum((256 * n > plain) << i for i, n in enumerate((l, up, ul, ur, 2 * l - ll, 2 * up - uu)))
        kind += 64 * min(self.off.bit_length() >> 1, 3)
        self.candidates, self.plain, self.kind = c, plain, kind
        return clamp(plain + (self.bias[kind] >> 8), 256, 256 * last)

    def drawn(self, b, u, v, at):
        origin, dx, dy = b.surface
        last = self.s.levels.last
        q = origin + dx * u + dy * v
        q4 = origin + dx * (u // 8 * 8 + 4) + dy * (v // 8 * 8 + 4)
        limit = 256 * (12 + 3 * self.s.bounds.halves(u // 8, v // 8)[clamp((q4 + 128) >> 8, 1, last)])
        total = weight = 0
        for n, w, expected in ((at(-1, 0), 4, q - dx), (at(0, -1), 4, q - dy), (at(-1, -1), 1, q - dx - dy),
                               (at(1, -1), 2, q + dx - dy)):
            off = 256 * n.level - expected
            if n.level and abs(off) <= limit:
                total, weight = total + w * off, weight + w
        return clamp(q + ((total * self.s.drift[weight]) >> 16), 256, 256 * last)

    def contexts(self, b, q, prediction, step, at):
        l, up, ul, ur, ll, uu = self.levels
        s = -1 if q < 256 * prediction else 1
        inverse = 65536 // step

        def to(level):
            return (clamp(level - prediction, -4096, 4096) * s * inverse + 32768) >> 16

        def to4(c):
            return (clamp(c - 4 * prediction, -16384, 16384) * s * (inverse // 4) + 32768) >> 16

        e = [s * at(*d).error for d in ((-1, 0), (0, -1), (-1, -1), (1, -1), (-2, 0), (0, -2))]
        by_error = log_class(2 * (abs(e[0]) + abs(e[1])) + sum(map(abs, e[2:])), 11)
        slopes = min(abs(l - ul) + abs(up - ul) + abs(up - ur), 16383)
        digits = 0
        for n in e:
            digits = 3 * digits + min(abs(n), 2)
        contexts = (8 * by_error + log_class((slopes * inverse) >> 16, 7),
                    12 * min(abs(q - 256 * prediction) >> 4, 7) + log_class(self.off, 11),
                    21 * graded(to(l)) + 3 * graded(to(up)) + lim(to(ur), 1),
                    45 * lim(e[0], 2) + 9 * lim(e[1], 2) + 3 * lim(e[2], 1) + lim(e[3], 1),
                    30 * lim(to4(self.candidates[0]), 2) + 6 * lim(to4(self.candidates[1]), 2) +
                    (lim(to4(self.candidates[7]), 2) if b.first else 5),
                    sum(same << i for i, same in enumerate((l == ul, up == ul, up == ur, l == ll, up == uu,
                                                            l == up, prediction == l))),
                    digits,
                    25 * lim(to(2 * l - ll), 2) + 5 * lim(to(2 * up - uu), 2) + lim(to(l + ur - up), 2))
        return by_error, [sum(PIXEL_SIZES[:i]) + c for i, c in enumerate(contexts)], s < 0

    def blended(self, b, p, u, v, at):
        last = self.s.levels.last
        q = self.blend(b, u, v, at)
        prediction = (q + 128) >> 8
        half = self.s.bounds.halves(u // 8, v // 8)[prediction]
        step = half + half // 2 + 1
        mixer, contexts, mirrored = self.contexts(b, q, prediction, step, at)

        def decide(slot):
            return mixed(self.c, [self.m.mix_pixel[c * SLOTS + slot] for c in contexts],
                         self.m.mix_pixel_weights[slot * MIXERS + mixer])

        level, correction, count = prediction, 0, None
        if decide(0):
            sign = 1 if decide(1) != mirrored else -1
            size = self.size(decide)
            correction = sign * size
            level = prediction + correction * step
            if size > 12:
                level, count = self.jump(prediction, sign)
        bad_unless(1 <= level <= last)
        p.level = self.fallback = level
        p.error = correction
        shift = step.bit_length() - 1
        p.misses = tuple(min(abs(4 * level - c) >> shift, 255) for c in self.candidates)
        missed = clamp(256 * level - self.plain, -1024 * step, 1024 * step)
        self.bias[self.kind] += quot(256 * missed - self.bias[self.kind], 64)
        return self.s.levels.depth[level] if count is None else count

    def size(self, decide):
        group = 0
        while group < 7 and decide(2 + group):
            group += 1
        if group < 4:
            return group + 1
        if group == 7:
            return 13
        least, bits = ((5, 1), (7, 1), (9, 2))[group - 4]
        return least + self.c.tree(self.m.mix_low[4 * (group - 4):], bits)

    def jump(self, prediction, sign):
        length = self.c.tree(self.m.jump_length, 5)
        if length == 0:
            count = self.c.raw(16)
            bad_unless(count)
            return self.s.levels.nearest(count), count
        bad_unless(length <= 16)
        distance = 2 + self.c.bit(self.m.jump_top[length]) if length > 1 else 1
        if length > 2:
            distance = (distance << (length - 2)) + self.c.raw(length - 2)
        return prediction + sign * distance, None


def mix_tile(stream, coder, models, depth):
    MixTile(stream, coder, models, depth).decode()
