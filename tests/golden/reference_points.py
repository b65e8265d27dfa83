#!/usr/bin/env python3
"""Section 16 of docs/wire-format.md: point tiles, written from the specification.

usage: reference_points.py PROGRAM CONSTANTS_FOLDER
PROGRAM prints lines "tolerance max_points body points", the last two as hexadecimal: the body of a
slice and what the decoder made of it, 12 bytes a point, little-endian.
"""
import math
import re
import struct
import subprocess
import sys

from reference_coder import Coder, bad_unless

MOST_NODES = 131072
KNOTS = [round(65536 / (1 + math.exp(-i / 2))) for i in range(-16, 17)]


def squash(x):
    y = x + 2048
    i, r = y >> 7, y & 127
    return (KNOTS[i] * (128 - r) + KNOTS[i + 1] * r + 64) >> 7


def make_stretch():
    table, x = [], -2047
    for p in range(4096):
        while x < 2047 and squash(x) < 16 * p + 8:
            x += 1
        table.append(x)
    return table


STRETCH = make_stretch()


def rate(n):
    return 655360 // (10 * n + 16)


class Trained:
    """What every slice starts from: the constants, unfolded."""
    SEEN = (0, 1, 1, 1, 2, 2, 3, 4, 5, 6, 8, 10, 13, 17, 23, 30)
    AGES = (0, 1, 2, 3, 4, 5, 6, 9, 12, 16, 22, 30, 40, 60, 80, 100)

    def __init__(self, folder):
        def numbers(name):
            with open(f"{folder}/point_{name}_trained.inc", encoding="ascii") as file:
                return [int(n) for n in re.findall(r"-?\d+", file.read())]

        def unfold(start, ages):
            p = (start >> 4) * 16 + 8
            return [p, p, ages[start & 15]]
        self.occupancy = [unfold(n, self.SEEN) for n in numbers("occupancy")]
        self.counts = [unfold(n, self.AGES) for n in numbers("counts")]
        self.weights = numbers("weights")


class PointTile:
    FACES, AROUND, PLANE = 27 * 256, 40 * 16, 15 * 16 * 3

    def __init__(self, trained, body, tolerance, max_points):
        self.c = Coder(body)
        self.occupancy = [list(m) for m in trained.occupancy]
        self.counts = [list(m) for m in trained.counts]
        self.weights = list(trained.weights)
        self.cube = (2 * math.isqrt(tolerance * tolerance // 3) + 1) << 16
        self.max_points, self.out = max_points, []

    def number(self, n):
        value, first = 0, (n - 1) % 16 + 1
        while n > 0:
            value = value << first | self.c.raw(first)
            n, first = n - first, 16
        return value

    def decode(self):
        kind = self.c.raw(2)
        bad_unless(kind < 2)
        length = self.c.raw(6)
        bad_unless(length <= 32)
        self.n = self.number(length)
        bad_unless(self.n <= self.max_points)
        self.axes = []
        for _ in range(3):
            pitch = self.number(48) if self.c.raw(1) else self.cube
            bad_unless(1 << 16 <= pitch <= 1 << 47)
            self.axes.append((self.number(32), pitch))
        self.plain() if kind == 0 else self.tree()
        bad_unless(len(self.out) == self.n and self.c.ended())
        return b"".join(struct.pack("<3I", *(v ^ 0x80000000 for v in p)) for p in self.out)

    def put(self, cell, count):
        bad_unless(len(self.out) + count <= self.n)
        point = []
        for c, (base, pitch) in zip(cell, self.axes):
            bad_unless(c <= (((1 << 32) - base) << 16) // pitch + 1)
            point.append(min(base + ((c * pitch + 0x8000) >> 16), (1 << 32) - 1))
        self.out += [point] * count

    def plain(self):
        widths = [self.c.raw(6) for _ in range(3)]
        bad_unless(max(widths) <= 32)
        for _ in range(self.n):
            self.put([self.number(w) for w in widths], 1)

    def tree(self):
        depth, group = self.c.raw(6), self.c.raw(2)
        bad_unless(depth <= 32)
        nodes = [(0, 0, 0)] if self.n else []
        for level in range(depth - 1, -1, -1):
            nodes = self.level(nodes, level)
        self.count_cells(nodes, group)

    def level(self, nodes, level):
        here, masks, below = {node: i for i, node in enumerate(nodes)}, [], []
        for i, node in enumerate(nodes):
            near = {}
            for d in ((x, y, z) for z in (-1, 0, 1) for y in (-1, 0, 1) for x in (-1, 0, 1)):
                at = tuple(a + b for a, b in zip(node, d))
                if at in here:
                    near[d] = here[at]
            masks.append(0)
            if level > 0 and len(near) == 1 and self.c.bit(self.counts[min(level, 31)]):
                cell = node
                for _ in range(level + 1):
                    o = self.c.raw(3)
                    cell = tuple(2 * a + (o >> k & 1) for k, a in enumerate(cell))
                self.put(cell, 1)
                continue
            k, distances = plane(near)
            for o in range(8):
                if o < 7 or masks[i]:
                    occupied = self.mixed(level, self.contexts(near, masks, i, o, k, distances), k)
                else:
                    occupied = 1
                if occupied:
                    masks[i] |= 1 << o
                    below.append(tuple(2 * a + (o >> j & 1) for j, a in enumerate(node)))
                    bad_unless(len(below) <= min(self.n, MOST_NODES))
        return below

    @staticmethod
    def contexts(near, masks, i, o, k, distances):
        def state(at):
            d = tuple(a >> 1 for a in at)
            if d not in near:
                return 0
            octant = sum((a & 1) << j for j, a in enumerate(at))
            if near[d] <= i:
                return 2 * (masks[near[d]] >> octant & 1)
            return 1
        mine = [o >> j & 1 for j in range(3)]
        known = unknown = faces = 0
        for d in ((x, y, z) for z in (-1, 0, 1) for y in (-1, 0, 1) for x in (-1, 0, 1)):
            far = sum(map(abs, d))
            if far == 0:
                continue
            at = [a + b for a, b in zip(mine, d)]
            s = state(at)
            known += 4 - far if s == 2 else 0
            unknown += s == 1
            if far == 1:
                axis = [abs(v) for v in d].index(1)
                if not 0 <= at[axis] <= 1:
                    faces += s * 3 ** axis
        bits = bin(masks[i]).count("1")
        return (faces * 256 + (1 << o | masks[i]),
                PointTile.FACES + min(known, 39) * 16 + min(unknown, 15),
                PointTile.FACES + PointTile.AROUND + (k * 16 + distances[o]) * 3 +
                (0 if bits == 0 else 1 if bits < 3 else 2))

    def mixed(self, level, contexts, k):
        upper = 0 if level == 0 else 1
        first = upper * (self.FACES + self.AROUND + self.PLANE)
        models = [self.occupancy[first + c] for c in contexts]
        w = (upper * 15 + k) * 3
        odds = [STRETCH[(m[0] + m[1]) >> 5] for m in models]
        x = min(max(sum(self.weights[w + j] * s for j, s in enumerate(odds)) >> 16, -2047), 2047)
        p = min(max(squash(x), 32), 65504)
        split = (self.c.range >> 16) * p
        one = int(self.c.code < split)
        if one:
            self.c.range = split
        else:
            self.c.code -= split
            self.c.range -= split
        self.c.normalise()
        error = 65536 * one - p
        for j, m in enumerate(models):
            moved = self.weights[w + j] + ((odds[j] * error + 16384) >> 15)
            self.weights[w + j] = min(max(moved, -(1 << 19)), 1 << 19)
            m[0] += ((65535 * one - m[0]) * rate(min(m[2], 14))) >> 16
            m[1] += ((65535 * one - m[1]) * rate(m[2])) >> 16
            m[2] = min(m[2] + 1, 150)
        return one

    def count_cells(self, cells, group):
        density, first = 0, 0
        while first < len(cells):
            end = first
            while end < len(cells) and all(a >> group == b >> group
                                           for a, b in zip(cells[first], cells[end])):
                end += 1
            m = end - first
            c = 4 * (min(m.bit_length(), 5) - 1) + sum(density >= d for d in (2, 16, 64))
            size = 0
            while size < 32 and self.c.bit(self.counts[32 + c * 33 + size]):
                size += 1
            extra = size
            if size >= 2:
                extra = 2 | self.c.bit(self.counts[32 + 20 * 33 + size])
                left = size - 2
                while left > 0:
                    part = min(left, 16)
                    extra, left = extra << part | self.c.raw(part), left - part
            bad_unless(extra <= self.n)
            for i in range(m):
                self.put(cells[first + i], 1 + (i + 1) * extra // m - i * extra // m)
            density = (3 * density + min(16 * extra // m, 1 << 16)) // 4
            first = end


def quot(a, b):
    return a // b if a >= 0 else -(-a // b)


def plane(near):
    n = len(near)
    total = [sum(d[i] for d in near) for i in range(3)]
    c = [[n * sum(d[i] * d[j] for d in near) - total[i] * total[j] for j in range(3)] for i in range(3)]
    a = [[0] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(3):
            i1, i2, j1, j2 = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
            a[j][i] = c[i1][j1] * c[i2][j2] - c[i1][j2] * c[i2][j1]

    def shorten(v):
        e = max(abs(x) for x in v).bit_length() - 12
        return [quot(x, 1 << e) for x in v] if e > 0 else v
    best = max(range(3), key=lambda i: (a[i][i], -i))
    v = shorten([a[i][best] for i in range(3)])
    for _ in range(2):
        v = shorten([sum(a[i][j] * v[j] for j in range(3)) for i in range(3)])
    l1 = sum(map(abs, v))
    crowd = 5 * (0 if n < 5 else 1 if n < 9 else 2)
    if l1 == 0:
        return crowd + 4, [0] * 8
    thick = 1000 * sum(v[i] * c[i][j] * v[j] for i in range(3) for j in range(3))
    flat = sum(thick >= f * l1 * l1 * n * n for f in (29, 58, 109))
    dot = sum(x * t for x, t in zip(v, total))
    distances = []
    for o in range(8):
        there = sum(x if o >> i & 1 else -x for i, x in enumerate(v))
        distances.append(min(5 * abs(4 * dot - n * there) // (n * l1), 15))
    return crowd + flat, distances


def main():
    trained = Trained(sys.argv[2])
    run = subprocess.run([sys.argv[1]], check=True, capture_output=True, text=True)
    wrong = slices = points = 0
    for line in run.stdout.splitlines():
        tolerance, most, body, expected = line.split()
        found = PointTile(trained, bytes.fromhex(body), int(tolerance), int(most)).decode()
        expected = bytes.fromhex(expected) if expected != "-" else b""
        slices, points = slices + 1, points + len(expected) // 12
        if found != expected:
            wrong += 1
            print(f"tolerance {tolerance}: {len(found) // 12} points differ from {len(expected) // 12}")
    print(f"{slices} slices, {points} points, {wrong} slices differ")
    return 1 if wrong or slices < 20 else 0


if __name__ == "__main__":
    sys.exit(main())
