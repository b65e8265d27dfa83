"""Section 7.6 of docs/wire-format.md: tiles coded by runs."""
from reference_coder import bad_unless

RUNS = [(n, 0) for n in range(6)] + [(6, 1), (8, 2), (12, 3), (20, 4), (36, 5), (68, 6), (132, 8), (388, 12)]
STEPS = [(0, 0), (1, 0), (2, 0), (3, 1), (5, 2), (9, 3), (17, 4), (33, 16)]


def symbol_models():
    return [[[0] + [2048 * i for i in range(1, 16)] for _ in range(3)] for _ in range(2)]


def run_tile(tile):
    c, s = tile.c, tile.s
    runs, misses, levels = symbol_models(), symbol_models(), {}
    left = len(tile.us) * len(tile.vs)
    reading = size = 0
    last = 1

    def number(first, bits):
        return first + (c.raw(bits) if bits else 0)

    def run():
        k = c.symbol(runs[reading][size])
        if k == 15:
            return left
        n = 4484 + (c.raw(6) << 16) + c.raw(16) if k == 14 else number(*RUNS[k])
        bad_unless(n < left)
        return n

    to_come = run()
    for v in tile.vs:
        for u in tile.us:
            left -= 1
            l, a, al = (levels.get(at, 0) for at in ((u - 1, v), (u, v - 1), (u - 1, v - 1)))
            level = max(min(l, a), min(max(l, a), l + a - al))
            if min(l, a) == 0 and al > 0:
                level = 0
            count = None
            if to_come > 0:
                to_come -= 1
            else:
                k = c.symbol(misses[int(level > 0)][size])
                if k == 15:
                    count, size = c.raw(16), 2
                    level = s.levels.nearest(count)
                    bad_unless(level > 0)
                elif k == 0 and level > 0:
                    level = size = 0
                else:
                    start = level or l or a or last
                    n = number(*STEPS[(k + 1) >> 1])
                    step = 2 * s.bounds.halves(u // 8, v // 8)[start] + 1
                    level = start + n * step if k & 1 else start - n * step
                    bad_unless(1 <= level <= s.levels.last)
                    size = min((k + 1) >> 1, 2)
                reading = int(level > 0)
                last = level or last
                if left:
                    to_come = run()
            levels[u, v] = level
            tile.depth[v * s.width + u] = (s.levels.depth[level] if level else 0) if count is None else count
