#!/usr/bin/env python3
"""Receives triangle meshes from dexeld: a client of its mesh socket in one file.

    import dexel

    for mesh in dexel.subscribe(encoding="delta"):
        print(mesh.epoch, len(mesh.changed), mesh.n_triangles)

Each turn of the loop is one COMMIT: a whole, current mesh, as tiles that fit each other. It goes on
when the service restarts, and ends when a replay is over. `mesh.weld()` makes one list of vertices
and triangles of the tiles; `mesh.write_ply(path)` writes them.

Only the standard library is needed, and Python 3.9. Where numpy is there, vertices, triangles,
attributes and normals are its arrays; otherwise they are lists (of tuples), twenty to two hundred
times slower, that can be iterated, indexed and counted in the same way.

It follows docs/protocol.md, whose words it uses. One thread may use a subscription at a time; only
close() may be called from another.

Run as a program (python3 -m dexel --help) it prints a line for each mesh, and writes PLY.
"""
from __future__ import annotations

import argparse
import errno
import json
import math
import os
import socket
import struct
import sys
import threading
import time
from array import array
from typing import (Any, Callable, Dict, FrozenSet, Iterator, List, NamedTuple, NoReturn, Optional,
                    Sequence, Tuple, Union)

try:
    import numpy as np
except ImportError:
    np = None  # type: ignore[assignment]

__all__ = ["subscribe", "streams", "Subscription", "Stream", "Mesh", "Tile", "Surface", "Error",
           "ProtocolError", "ServerError", "ConnectionLost", "StreamFailed"]

VERSION = (1, 0)
ENCODINGS = ("f32", "q16", "delta")
MODES = ("live", "pull", "lossless")
MODELS = {1: "spinning", 2: "pinhole", 3: "table"}
STATES = ("opening", "live", "stalled", "gone", "ended", "faulted")
CLOCKS = {0: "none", 1: "realtime", 2: "monotonic", 3: "device"}
DEFAULT_SOCKET = "/run/dexeld/mesh.sock"
DEFAULT_CONTROL = "/run/dexeld/control.sock"

#: Seconds in which a server must say what is due: its WELCOME, the rest of a message or of a batch.
PATIENCE_S = 30.0

_MAGIC = 0x4C584544
_NO_STREAM = 0xFFFFFFFF
_MAX_BODY = 262144
_MAX_BODY_BEFORE_WELCOME = 1024
_MAX_CONTROL = 4 << 20
_SKIPPABLE = 1
(_HELLO, _WELCOME, _ERROR, _SUBSCRIBE, _SUBSCRIBED, _GEOMETRY, _TILE, _COMMIT, _RESET,
 _SNAPSHOT_BEGIN, _SNAPSHOT_END, _STREAM_STATE, _NEXT) = range(1, 14)
_NAMES = ("", "HELLO", "WELCOME", "ERROR", "SUBSCRIBE", "SUBSCRIBED", "GEOMETRY", "TILE", "COMMIT",
          "RESET", "SNAPSHOT_BEGIN", "SNAPSHOT_END", "STREAM_STATE", "NEXT")

_HEADER = struct.Struct("<IHHIIQ")
_HELLO_BODY = struct.Struct("<IHHII")
_WELCOME_BODY = struct.Struct("<IHHIIII")
_SUBSCRIBE_BODY = struct.Struct("<4BI5H")
_SUBSCRIBED_BODY = struct.Struct("<12BIIHHfI12d3d3dH")
_COMMIT_BODY = struct.Struct("<QQQQIII")
_CHUNK = struct.Struct("<HHBBHH")

_SIDE = 67  # dexels along a side of a tile's block
_BLOCK = _SIDE * _SIDE
_MASK_BYTES = 562
_MAX_TRIANGLES = 8712
_MAX_DEXELS = 1 << 28

Key = Tuple[int, int]


class Error(Exception):
    """What goes wrong between this client and a service."""


class ProtocolError(Error):
    """The server says what the protocol does not allow."""


class ServerError(Error):
    """The server refuses: its ERROR, with `code` and `text`."""

    #: Codes after which another connection may be served: it is full, we were too slow, it stops.
    PASSING = (6, 7, 8)
    WHAT = {1: "protocol", 2: "version", 3: "no such stream", 4: "encoding", 5: "mode", 6: "limit",
            7: "too slow", 8: "the service shuts down", 9: "disconnected"}

    def __init__(self, code: int, text: str) -> None:
        super().__init__(f"{text or 'no reason given'} ({self.WHAT.get(code, 'error')}, {code})")
        self.code = code
        self.text = text


class ConnectionLost(Error):
    """The connection ended, or the server fell silent in the middle of something."""


class StreamFailed(Error):
    """The stream's source failed, and no more will come."""


class Stream(NamedTuple):
    """A stream as SUBSCRIBED told it; see docs/protocol.md for each field."""

    name: str
    encoding: str
    mode: str
    attr_bytes: int
    model: str
    wrap: bool
    flip: bool
    range_bytes: int
    diag: int
    paper: bool
    normals: bool
    smooth: bool
    stride: int
    height: int
    width: int
    tile_rows: int
    tile_cols: int
    unit_m: float
    table_bytes: int
    #: Three rows of four: [R|t], scanner to world.
    pose: Tuple[Tuple[float, ...], ...]
    sigma: Tuple[float, ...]
    tilt_deg: float
    noise_k: float
    cap_m: float
    #: Level of detail, in sigmas.
    bound: float


class Tile:
    """One tile of a mesh, which never changes: another takes its place.

    `vertices` are V times (x, y, z), metres, in the scanner's frame; `triangles` T times three
    indices into them, counter-clockwise as the scanner sees them; `attributes` V integers, or None.
    """

    __slots__ = ("row", "col", "vertices", "triangles", "attributes", "_stream", "_block",
                 "_normal_bytes")

    def __init__(self, key: Key, stream: Stream, block: Any, vertices: Any, triangles: Any,
                 attributes: Any, normal_bytes: Optional[memoryview]) -> None:
        self.row, self.col = key
        self.vertices = vertices
        self.triangles = triangles
        self.attributes = attributes
        self._stream = stream
        self._block = block
        self._normal_bytes = normal_bytes

    def __repr__(self) -> str:
        return (f"<Tile ({self.row}, {self.col}): {len(self.vertices)} vertices, "
                f"{len(self.triangles)} triangles>")

    @property
    def names(self) -> Any:
        """For each vertex row * width + column of its dexel: equal names are one vertex."""
        width = self._stream.width
        row0, col0 = 64 * self.row - 1, 64 * self.col - 1
        if isinstance(self._block, list):
            return [(row0 + k // _SIDE) * width + (col0 + k % _SIDE) % width for k in self._block]
        rows, cols = np.divmod(self._block, _SIDE)
        return (rows + row0) * width + (cols + col0) % width

    @property
    def normals(self) -> Any:
        """For each vertex a unit vector to the scanner's side; None where they do not come."""
        if self._normal_bytes is None:
            return None
        if isinstance(self._block, list):
            pairs = struct.iter_unpack("2b", self._normal_bytes)
            return [_normal(a, b) for a, b in pairs]
        return _normal_table()[np.frombuffer(self._normal_bytes, "<u2")]


class Surface(NamedTuple):
    """A mesh in one piece: a vertex of several tiles is there once, in the order of names."""

    names: Any
    vertices: Any
    triangles: Any
    attributes: Any
    normals: Any


class Mesh:
    """The mesh of one epoch.

    `tiles` are all that have triangles, by (row, column). `changed` are the keys of those that are
    not as in the mesh before, also of those that are gone; `fresh` says that nothing of the mesh
    before holds: it is the first, or the first after a RESET or another connection.
    """

    __slots__ = ("stream", "epoch", "frame", "host_ns", "device_ns", "clock", "n_dropped",
                 "partial", "caps", "tiles", "changed", "fresh")

    def __init__(self, stream: Stream, epoch: int, commit: Tuple[int, ...], tiles: Dict[Key, Tile],
                 changed: FrozenSet[Key], fresh: bool) -> None:
        self.stream = stream
        self.epoch = epoch
        self.frame, self.host_ns, self.device_ns, self.n_dropped, clock, _, flags = commit
        self.clock = CLOCKS[clock]
        self.partial = bool(flags & 1)
        #: Whether a fan lies over the first row, and over the last; weld() makes its triangles.
        self.caps = (bool(flags & 2), bool(flags & 4))
        self.tiles = tiles
        self.changed = changed
        self.fresh = fresh

    def __repr__(self) -> str:
        return (f"<Mesh of {self.stream.name}, epoch {self.epoch}, frame {self.frame}: "
                f"{len(self.tiles)} tiles, {self.n_triangles} triangles>")

    @property
    def n_triangles(self) -> int:
        """Triangles of all tiles, without caps."""
        return sum(len(tile.triangles) for tile in self.tiles.values())

    def weld(self) -> Surface:
        """All tiles and the caps in one piece."""
        tiles = [self.tiles[key] for key in sorted(self.tiles)]
        if tiles and not isinstance(tiles[0]._block, list):
            return _weld_arrays(self, tiles)
        return _weld_lists(self, tiles)

    def write_ply(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes weld() as a binary PLY file; a file that was there is replaced as a whole."""
        surface = self.weld()
        temporary = f"{os.fspath(path)}.{os.getpid()}.tmp"
        try:
            with open(temporary, "wb") as out:
                _put_ply(out, surface)
            os.replace(temporary, path)
        except BaseException:
            if os.path.exists(temporary):
                os.unlink(temporary)
            raise


# ---------------------------------------------------------------------------------------- welding


def _cap_fans(mesh: Mesh) -> List[List[Tuple[int, int, int]]]:
    """The triangles of the caps, by names of vertices."""
    height, width = mesh.stream.height, mesh.stream.width
    fans = []
    for there, row, turned in ((mesh.caps[0], 0, True), (mesh.caps[1], height - 1, False)):
        if not there:
            continue
        first = row * width
        if turned != mesh.stream.flip:
            fans.append([(first, first + j + 1, first + j) for j in range(1, width - 1)])
        else:
            fans.append([(first, first + j, first + j + 1) for j in range(1, width - 1)])
    return fans


def _weld_lists(mesh: Mesh, tiles: Sequence[Tile]) -> Surface:
    where: Dict[int, Tuple[Tile, int]] = {}
    for tile in tiles:
        for rank, name in enumerate(tile.names):
            where.setdefault(name, (tile, rank))
    names = sorted(where)
    index = {name: i for i, name in enumerate(names)}
    triangles = []
    for tile in tiles:
        own = [index[name] for name in tile.names]
        triangles += [(own[a], own[b], own[c]) for a, b, c in tile.triangles]
    for fan in _cap_fans(mesh):
        if all(name in index for corners in fan for name in corners):
            triangles += [(index[a], index[b], index[c]) for a, b, c in fan]
    vertices = [where[name][0].vertices[where[name][1]] for name in names]
    attributes = normals = None
    if mesh.stream.attr_bytes:
        attributes = [where[name][0].attributes[where[name][1]] for name in names]
    if mesh.stream.normals:
        of = {id(tile): tile.normals for tile in tiles}
        normals = [of[id(where[name][0])][where[name][1]] for name in names]
    return Surface(names, vertices, triangles, attributes, normals)


def _weld_arrays(mesh: Mesh, tiles: Sequence[Tile]) -> Surface:
    names, first, inverse = np.unique(np.concatenate([tile.names for tile in tiles]),
                                      return_index=True, return_inverse=True)
    inverse = inverse.reshape(-1)
    triangles = []
    offset = 0
    for tile in tiles:
        n = len(tile.vertices)
        triangles.append(inverse[offset:offset + n][tile.triangles])
        offset += n
    for fan in _cap_fans(mesh):
        corners = np.array(fan).reshape(-1, 3)
        at = np.minimum(np.searchsorted(names, corners), len(names) - 1)
        if (names[at] == corners).all():
            triangles.append(at)

    def of(values: List[Any]) -> Any:
        return np.concatenate(values)[first]

    return Surface(names, of([tile.vertices for tile in tiles]),
                   np.concatenate(triangles).astype(np.uint32),
                   of([tile.attributes for tile in tiles]) if mesh.stream.attr_bytes else None,
                   of([tile.normals for tile in tiles]) if mesh.stream.normals else None)


def _put_ply(out: Any, surface: Surface) -> None:
    columns = [("x", "float", "f"), ("y", "float", "f"), ("z", "float", "f")]
    if surface.normals is not None:
        columns += [("nx", "float", "f"), ("ny", "float", "f"), ("nz", "float", "f")]
    if surface.attributes is not None:
        columns.append(("intensity", "ushort", "H"))
    out.write("\n".join([
        "ply", "format binary_little_endian 1.0", "comment dexel.py, metres, scanner frame",
        f"element vertex {len(surface.vertices)}", *(f"property {t} {n}" for n, t, _ in columns),
        f"element face {len(surface.triangles)}", "property list uchar int vertex_indices",
        "end_header", ""]).encode())
    if isinstance(surface.vertices, list):
        line = struct.Struct("<" + "".join(code for _, _, code in columns))
        for i, vertex in enumerate(surface.vertices):
            normal = surface.normals[i] if surface.normals is not None else ()
            attribute = (surface.attributes[i],) if surface.attributes is not None else ()
            out.write(line.pack(*vertex, *normal, *attribute))
        face = struct.Struct("<B3i")
        out.writelines(face.pack(3, a, b, c) for a, b, c in surface.triangles)
        return
    table = np.empty(len(surface.vertices), [(n, "<f4" if c == "f" else "<u2") for n, _, c in columns])
    table["x"], table["y"], table["z"] = surface.vertices.T
    if surface.normals is not None:
        table["nx"], table["ny"], table["nz"] = surface.normals.T
    if surface.attributes is not None:
        table["intensity"] = surface.attributes
    out.write(table.tobytes())
    faces = np.empty(len(surface.triangles), [("n", "u1"), ("corners", "<i4", 3)])
    faces["n"] = 3
    faces["corners"] = surface.triangles
    out.write(faces.tobytes())


# ---------------------------------------------------------------------------------------- normals


def _f32(values: Any) -> "array[float]":
    """Rounds each to binary32. One operation on binary32 values, done in binary64 and rounded so,
    is what binary32 itself would have given."""
    return array("f", values)


def _normal_of(a: int, b: int) -> Tuple[float, float, float]:
    def rounded(value: float) -> float:
        return _f32((value,))[0]

    u, v = rounded(a / 127), rounded(b / 127)
    w = rounded(rounded(1 - abs(u)) - abs(v))
    if w < 0:
        u, v = (rounded(1 - abs(v)) * (-1 if u < 0 else 1), rounded(1 - abs(u)) * (-1 if v < 0 else 1))
    squares = rounded(rounded(rounded(u * u) + rounded(v * v)) + rounded(w * w))
    length = rounded(math.sqrt(squares))
    return rounded(u / length), rounded(v / length), rounded(w / length)


_normals: Dict[Key, Tuple[float, float, float]] = {}


def _normal(a: int, b: int) -> Tuple[float, float, float]:
    found = _normals.get((a, b))
    if found is None:
        found = _normals[a, b] = _normal_of(a, b)
    return found


_normals_of_bytes: Any = None


def _normal_table() -> Any:
    """The vectors of all pairs of bytes, by the pair as a little-endian number."""
    global _normals_of_bytes
    if _normals_of_bytes is None:
        pairs = np.arange(65536, dtype="<u2").view("i1").reshape(-1, 2).astype(np.float32)
        u, v = pairs.T / np.float32(127)
        w = (np.float32(1) - abs(u)) - abs(v)
        one = np.float32(1)
        below = w < 0
        u, v = (np.where(below, (one - abs(v)) * np.where(u < 0, -one, one), u),
                np.where(below, (one - abs(u)) * np.where(v < 0, -one, one), v))
        length = np.sqrt((u * u + v * v) + w * w)
        _normals_of_bytes = np.stack([u / length, v / length, w / length], axis=1)
    return _normals_of_bytes


# ----------------------------------------------------------------------------- cells and struts

_A, _B, _D, _C = 0, 1, _SIDE, _SIDE + 1
_OUTCOMES = ((), ((_A, _B, _C),), ((_A, _C, _D),), ((_A, _B, _C), (_A, _C, _D)), ((_A, _B, _D),),
             ((_B, _C, _D),), ((_A, _B, _D), (_B, _C, _D)))


def _turned(triangles: Sequence[Tuple[Any, Any, Any]]) -> Tuple[Tuple[Any, Any, Any], ...]:
    return tuple((a, c, b) for a, b, c in triangles)


#: By flip and code the triangles of a cell, as block dexels from its corner a.
_CELL_TRIANGLES = (_OUTCOMES, tuple(_turned(outcome) for outcome in _OUTCOMES))

#: By side: the lengths that there are, s0 and s1 ("n": along = len), and how A s0 s1 B is filled.
_FAN_A, _FAN_S0, _LONE = "A s0 s1, A s1 B", "A s0 B, s0 s1 B", "A s0 B"
_STRUT_SIDES = (
    ((1, 2), None, None, None),
    ((1, 2), 0, 1, _FAN_A),
    ((2,), 0, 1, _FAN_S0),
    ((2,), 0, 2, _FAN_A),
    ((2,), 0, 2, _FAN_S0),
    ((1, 2), -1, "len", _FAN_A),
    ((1, 2), -1, "len", _FAN_S0),
    ((1,), -1, 2, _FAN_A),
    ((1,), -1, 2, _FAN_S0),
    ((2,), -1, 1, _FAN_A),
    ((2,), -1, 1, _FAN_S0),
)


class _Strut(NamedTuple):
    """What a code stands for, from the owner at (0, 0)."""

    first_row: int  # of the owner and all corners
    last_row: int
    first_col: int
    last_col: int
    triangles: Tuple[Tuple[Any, Any, Any], ...]  # block dexels from the owner


def _strut_of(code: int) -> Optional[_Strut]:
    """The strut of a code; None: the code is not valid."""
    n = code - 1
    second, first, length, across = n % 11, n // 11 % 5, 1 + n // 55 % 2, n // 110
    if first == second == 0 or any(length not in _STRUT_SIDES[s][0] for s in (first, second)):
        return None
    triangles: List[Any] = []
    for t, side in ((-1, first), (1, second)):
        if side == 0:
            continue
        _, along0, along1, filling = _STRUT_SIDES[side]
        if side == 1 and length == 1:
            filling = _LONE
        corner = {"A": (-1, 0), "B": (length, 0), "s0": (along0, t),
                  "s1": (length if along1 == "len" else along1, t)}
        made = [tuple(corner[word] for word in words.split()) for words in filling.split(", ")]
        triangles += made if (t == 1) != bool(across) else _turned(made)
    if across:
        triangles = [tuple((q, p) for p, q in corners) for corners in triangles]
    rows = [0] + [p for corners in triangles for p, _ in corners]
    cols = [0] + [q for corners in triangles for _, q in corners]
    return _Strut(min(rows), max(rows), min(cols), max(cols),
                  tuple(tuple(_SIDE * p + q for p, q in corners) for corners in triangles))


_STRUTS = (None,) + tuple(_strut_of(code) for code in range(1, 221)) + (None,) * 35


class _Chunk(NamedTuple):
    """A TILE's body taken apart, and where its tile lies in the grid."""

    key: Key
    n_vertices: int
    n_triangles: int
    rows: int  # of cells
    cols: int
    block_rows: Tuple[int, int]  # first and last block row, and column, that is in the grid
    block_cols: Tuple[int, int]
    attributes: Optional[memoryview]
    part: memoryview
    normals: Optional[memoryview]

    def in_grid(self, p: int, q: int) -> bool:
        return (self.block_rows[0] <= p <= self.block_rows[1] and
                self.block_cols[0] <= q <= self.block_cols[1])


def _read_struts(chunk: _Chunk, at: int, flip: bool) -> Tuple[List[Tuple[int, int, int]], int]:
    """Triangles (block dexels) of the strut section at `at`, and where it ends."""
    part = chunk.part
    if at + 2 > len(part):
        raise ProtocolError("a chunk without a strut section")
    n_left = part[at] | part[at + 1] << 8
    (p0, p1), (q0, q1) = chunk.block_rows, chunk.block_cols
    at += 2
    k = 0
    triangles: List[Tuple[int, int, int]] = []
    while n_left:
        if at >= len(part):
            raise ProtocolError("a strut section that does not end")
        skip = part[at]
        at += 1
        k += skip
        if skip == 255:
            continue
        code = part[at] if at < len(part) else 0
        at += 1
        strut = _STRUTS[code]
        if strut is None:
            raise ProtocolError(f"a strut of code {code}")
        p, q = divmod(k, _SIDE)
        if (p + strut.first_row < p0 or p + strut.last_row > p1 or
                q + strut.first_col < q0 or q + strut.last_col > q1):
            raise ProtocolError(f"a strut at {k} that leaves its block")
        triangles += [(k + a, k + c, k + b) if flip else (k + a, k + b, k + c) for a, b, c in strut.triangles]
        k += 1
        n_left -= 1
    return triangles, at


# --------------------------------------------------------------------------- strings of bits (delta)


def _bits(data: Any) -> bytes:
    """A byte of 0 or 1 for each bit, the lowest of each byte first."""
    if np is not None:
        return np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little").tobytes()
    n = 8 * len(data)
    text = format(int.from_bytes(data, "little"), f"0{n}b") if n else ""
    return text[::-1].encode().translate(_DIGITS)


_DIGITS = bytes((value & 1) for value in range(256))


def _bytes_of_bits(bits: bytes, end: int) -> int:
    """How many bytes a string of `end` bits takes; the rest of the last one is to be 0."""
    n = (end + 7) // 8
    if 8 * n > len(bits):
        raise ProtocolError("a chunk that is too short")
    if any(bits[end:8 * n]):
        raise ProtocolError("bits after the end of a string")
    return n


def _find_groups(bits: bytes, rows: int, cols: int) -> Tuple[List[int], int]:
    """Where each group of cell codes begins, and where the last one ends."""
    starts: List[int] = []
    widths = [8] * (cols // 8) + ([cols % 8] if cols % 8 else [])
    at = 0
    try:
        for _ in range(rows):
            for width in widths:
                starts.append(at)
                if not bits[at]:
                    at += 1
                elif not bits[at + 1]:
                    at += 2 + width
                elif not bits[at + 2]:
                    at += 3
                else:
                    at += 3 + 3 * width
    except IndexError:
        raise ProtocolError("cell codes that do not end") from None
    return starts, at


def _find_blocks(bits: bytes, n_values: int) -> Tuple[List[int], List[int], int]:
    """Where the residuals of each block begin, their widths, and where the last one ends."""
    starts: List[int] = []
    widths: List[int] = []
    at = width = 0
    for left in range(n_values, 0, -32):
        zero = bits.find(0, at)
        if zero < 0:
            raise ProtocolError("residuals that do not end")
        z = zero - at
        width += -(z + 1) // 2 if z & 1 else z // 2
        if not 0 <= width <= 32:
            raise ProtocolError(f"residuals of {width} bits")
        starts.append(zero + 1)
        widths.append(width)
        at = zero + 1 + width * min(32, left)
    return starts, widths, at


# ------------------------------------------------------------------- decoding: lists, without numpy


class _Lists:
    """Makes tiles of chunks, with lists."""

    def __init__(self, stream: Stream, tables: bytes) -> None:
        self.stream = stream
        values = array("f", tables)
        if sys.byteorder == "big":
            values.byteswap()
        self.tables = values

    def decode(self, chunk: _Chunk) -> Any:
        if self.stream.encoding == "f32":
            return self._tile(chunk, *self._f32(chunk))
        codes, at = (self._codes_q16 if self.stream.encoding == "q16" else self._codes_delta)(chunk)
        struts, at = _read_struts(chunk, at, self.stream.flip)
        block, triangles = self._topology(chunk, codes, struts)
        if self.stream.encoding == "q16":
            ranges = self._ranges_q16(chunk, at)
        else:
            ranges = self._ranges_delta(chunk, at, block)
        if 0 in ranges:
            raise ProtocolError("a vertex without a range")
        if self.stream.range_bytes == 2 and max(ranges) > 65535:
            raise ProtocolError("a range of more than 16 bits")
        return self._tile(chunk, block, self._points(chunk, block, ranges), triangles)

    def finish(self, tiles: List[Any]) -> List[Tile]:
        return tiles

    def _tile(self, chunk: _Chunk, block: List[int], vertices: List[Any], triangles: List[Any]) -> Tile:
        attributes = None
        if chunk.attributes is not None:
            code = "<%dH" if self.stream.attr_bytes == 2 else "<%dB"
            attributes = list(struct.unpack(code % chunk.n_vertices, chunk.attributes))
        if chunk.normals is not None and 0x80 in bytes(chunk.normals):
            raise ProtocolError("a normal of -128")
        return Tile(chunk.key, self.stream, block, vertices, triangles, attributes, chunk.normals)

    def _f32(self, chunk: _Chunk) -> Tuple[List[int], List[Any], List[Any]]:
        part, n = chunk.part, chunk.n_vertices
        block = [k for k, bit in enumerate(_bits(part[:_MASK_BYTES])) if bit]
        if len(block) != n or block[-1] >= _BLOCK or not all(chunk.in_grid(*divmod(k, _SIDE)) for k in block):
            raise ProtocolError("a mask that does not fit")
        vertices = list(struct.iter_unpack("<3f", part[_MASK_BYTES:_MASK_BYTES + 12 * n]))
        triangles = list(struct.iter_unpack("<3H", part[_MASK_BYTES + 12 * n:]))
        if any(max(corners) >= n for corners in triangles):
            raise ProtocolError("a triangle of a vertex that is not there")
        return block, vertices, triangles

    def _codes_q16(self, chunk: _Chunk) -> Tuple[Sequence[int], int]:
        n = chunk.rows * chunk.cols
        n_bytes = (3 * n + 7) // 8
        bits = _bits(chunk.part[:n_bytes])
        _bytes_of_bits(bits, 3 * n)
        codes = [x + 2 * y + 4 * z for x, y, z in zip(bits[:3 * n:3], bits[1:3 * n:3], bits[2:3 * n:3])]
        return codes, n_bytes

    def _codes_delta(self, chunk: _Chunk) -> Tuple[Sequence[int], int]:
        bits = _bits(chunk.part[:_MAX_CODE_BYTES])
        starts, end = _find_groups(bits, chunk.rows, chunk.cols)
        n_bytes = _bytes_of_bits(bits, end)
        codes: List[int] = []
        at = iter(starts)
        for _ in range(chunk.rows):
            for left in range(chunk.cols, 0, -8):
                width, start = min(8, left), next(at)
                if not bits[start]:
                    codes += [3] * width
                elif not bits[start + 1]:
                    codes += [6 if bit else 3 for bit in bits[start + 2:start + 2 + width]]
                elif not bits[start + 2]:
                    codes += [0] * width
                else:
                    three = bits[start + 3:start + 3 + 3 * width]
                    codes += [x + 2 * y + 4 * z for x, y, z in zip(three[::3], three[1::3], three[2::3])]
        return codes, n_bytes

    def _topology(self, chunk: _Chunk, codes: Sequence[int], struts: List[Any]) -> Tuple[List[int], List[Any]]:
        if 7 in codes:
            raise ProtocolError("a cell of code 7")
        outcomes = _CELL_TRIANGLES[self.stream.flip]
        triangles = []
        code = iter(codes)
        for i in range(1, chunk.rows + 1):
            for k in range(_SIDE * i + 1, _SIDE * i + 1 + chunk.cols):
                triangles += [(k + a, k + b, k + c) for a, b, c in outcomes[next(code)]]
        triangles += struts
        block = sorted({k for corners in triangles for k in corners})
        if len(block) != chunk.n_vertices or len(triangles) != chunk.n_triangles:
            raise ProtocolError("a chunk whose counts are not those of its codes")
        rank = {k: i for i, k in enumerate(block)}
        return block, [(rank[a], rank[b], rank[c]) for a, b, c in triangles]

    def _ranges_q16(self, chunk: _Chunk, at: int) -> Sequence[int]:
        if len(chunk.part) != at + 2 * chunk.n_vertices:
            raise ProtocolError("a chunk of another length")
        return struct.unpack(f"<{chunk.n_vertices}H", chunk.part[at:])

    def _ranges_delta(self, chunk: _Chunk, at: int, block: List[int]) -> Sequence[int]:
        predictor, start, at = _predictor(chunk, at)
        bits = _bits(chunk.part[at:])
        starts, widths, end = _find_blocks(bits, chunk.n_vertices)
        if _bytes_of_bits(bits, end) * 8 != len(bits):
            raise ProtocolError("a chunk of another length")
        expected = _PREDICTORS[predictor]
        known: Dict[int, int] = {}
        before = start
        for i, k in enumerate(block):
            width = widths[i // 32]
            shift = starts[i // 32] + i % 32 * width
            z = int.from_bytes(chunk.part[at + shift // 8:at + (shift + width + 7) // 8], "little")
            z = z >> shift % 8 & (1 << width) - 1
            w = known.get(k - 1) if k % _SIDE else None
            n, nw = known.get(k - _SIDE), known.get(k - _SIDE - 1) if k % _SIDE else None
            if w is not None and n is not None and nw is not None:
                value = expected(w, n, nw)
            else:
                value = w if w is not None else n if n is not None else before
            before = known[k] = value + (-(z + 1) // 2 if z & 1 else z // 2) & 0xFFFFFFFF
        return [known[k] for k in block]

    def _points(self, chunk: _Chunk, block: List[int], ranges: Sequence[int]) -> List[Any]:
        stream, tables = self.stream, self.tables
        row0, col0, width = 64 * chunk.key[0] - 1, 64 * chunk.key[1] - 1, stream.width
        rows = [row0 + k // _SIDE for k in block]
        cols = [(col0 + k % _SIDE) % width for k in block]
        r = _f32(map(stream.unit_m.__mul__, _f32(ranges)))

        def times(a: Any, b: Any) -> Any:
            return _f32([x * y for x, y in zip(a, b)])

        def plus(a: Any, b: Any) -> Any:
            return _f32([x + y for x, y in zip(a, b)])

        if stream.model == "pinhole":
            x, y = tables[:width], tables[width:]
            return list(zip(times(r, [x[j] for j in cols]), times(r, [y[i] for i in rows]), r))
        if stream.model == "table":
            at = [3 * (i * width + j) for i, j in zip(rows, cols)]
            return list(zip(*(times(r, [tables[k + m] for k in at]) for m in range(3))))
        c, s = ([tables[2 * j + m] for j in cols] for m in range(2))
        dx, dy, dz, ox, oy, oz = ([tables[2 * width + 6 * i + m] for i in rows] for m in range(6))
        u, v = plus(ox, times(r, dx)), plus(oy, times(r, dy))
        minus_vs = [-value for value in times(v, s)]
        return list(zip(plus(times(u, c), minus_vs), plus(times(u, s), times(v, c)), plus(oz, times(r, dz))))


def _predictor(chunk: _Chunk, at: int) -> Tuple[int, int, int]:
    """The predictor of a delta chunk, the range it starts from, and where its residuals begin."""
    if at + 5 > len(chunk.part):
        raise ProtocolError("a chunk that is too short")
    predictor, start = struct.unpack_from("<BI", chunk.part, at)
    if predictor > 3:
        raise ProtocolError(f"predictor {predictor}")
    return predictor, start, at + 5


def _median(w: int, n: int, nw: int) -> int:
    if nw >= max(w, n):
        return min(w, n)
    if nw <= min(w, n):
        return max(w, n)
    return w + n - nw


_PREDICTORS: Tuple[Callable[[int, int, int], int], ...] = (
    lambda w, n, nw: w + n - nw, lambda w, n, nw: (w + n) // 2, lambda w, n, nw: w, _median)

#: The most that the cell codes of a delta chunk can take.
_MAX_CODE_BYTES = 64 * 8 * (3 + 3 * 8) // 8

# --------------------------------------------------------------------------- decoding: with numpy


class _Delta(NamedTuple):
    """A delta tile whose ranges are still differences."""

    chunk: _Chunk
    block: Any
    triangles: Any
    predictor: int
    start: int
    residuals: Any


if np is not None:
    _BLOCK_ROW, _BLOCK_COL = np.divmod(np.arange(_BLOCK), _SIDE)
    #: Four codes of three bits, by the twelve.
    _FOUR_CODES = (np.arange(4096)[:, None] >> (0, 3, 6, 9) & 7).astype(np.uint8)
    _N_OF_CODE = np.array([len(outcome) for outcome in _OUTCOMES] + [0])
    _HAS_TRIANGLE = _N_OF_CODE[:, None] > (0, 1)
    #: By flip and code: two triangles' corners from corner a; 0 where there is none.
    _CORNERS = np.zeros((2, 8, 2, 3), np.uint16)
    for _flip, _outcomes in enumerate(_CELL_TRIANGLES):
        for _code, _outcome in enumerate(_outcomes):
            for _n, _corners in enumerate(_outcome):
                _CORNERS[_flip, _code, _n] = _corners
    _CORNERS = _CORNERS.reshape(2, 8, 6)


def _at(table: Any, indices: Any) -> Any:
    """Rows of a table. The indices are in it: not to check them again makes this ten times faster."""
    return table.take(indices, axis=0, mode="clip")


class _Arrays(_Lists):
    """Makes tiles of chunks, with numpy. Ranges of delta tiles are computed for a batch at once."""

    def __init__(self, stream: Stream, tables: bytes) -> None:
        super().__init__(stream, b"")
        self.tables = np.frombuffer(tables, "<f4").astype(np.float32)
        self._first_corners: Dict[Key, Any] = {}
        # glibc's malloc keeps as much as the largest block that was freed, and gives the rest back to
        # the kernel: without this one each batch spends most of its time in page faults
        np.empty(24 << 20, np.uint8)

    def decode(self, chunk: _Chunk) -> Any:
        if self.stream.encoding == "f32":
            return self._tile(chunk, *self._f32(chunk))
        if self.stream.encoding == "q16":
            codes, at = self._codes_q16(chunk)
            struts, at = _read_struts(chunk, at, self.stream.flip)
            block, triangles = self._topology(chunk, codes, struts)
            if len(chunk.part) != at + 2 * chunk.n_vertices:
                raise ProtocolError("a chunk of another length")
            return self._of_ranges(chunk, block, triangles, np.frombuffer(chunk.part[at:], "<u2"))
        codes, at = self._codes_delta(chunk)
        struts, at = _read_struts(chunk, at, self.stream.flip)
        block, triangles = self._topology(chunk, codes, struts)
        predictor, start, at = _predictor(chunk, at)
        return _Delta(chunk, block, triangles, predictor, start, self._residuals(chunk, at))

    def finish(self, tiles: List[Any]) -> List[Tile]:
        if self.stream.encoding != "delta":
            return tiles
        finished = []
        for predictor in range(4):
            group = [tile for tile in tiles if tile.predictor == predictor]
            if group:
                for tile, ranges in zip(group, _sum_up(group, predictor)):
                    finished.append(self._of_ranges(tile.chunk, tile.block, tile.triangles, ranges))
        return finished

    def _tile(self, chunk: _Chunk, block: Any, vertices: Any, triangles: Any) -> Tile:
        attributes = None
        if chunk.attributes is not None:
            attributes = np.frombuffer(chunk.attributes, "<u2" if self.stream.attr_bytes == 2 else "u1")
        if chunk.normals is not None and 0x80 in bytes(chunk.normals):
            raise ProtocolError("a normal of -128")
        return Tile(chunk.key, self.stream, block, vertices, triangles, attributes, chunk.normals)

    def _of_ranges(self, chunk: _Chunk, block: Any, triangles: Any, ranges: Any) -> Tile:
        if not ranges.all():
            raise ProtocolError("a vertex without a range")
        if self.stream.range_bytes == 2 and ranges.max() > 65535:
            raise ProtocolError("a range of more than 16 bits")
        return self._tile(chunk, block, self._points(chunk, block, ranges), triangles)

    def _f32(self, chunk: _Chunk) -> Any:
        part, n = chunk.part, chunk.n_vertices
        mask = np.unpackbits(np.frombuffer(part, np.uint8, _MASK_BYTES), bitorder="little")
        block = np.flatnonzero(mask)
        (p0, p1), (q0, q1) = chunk.block_rows, chunk.block_cols
        inside = mask[:_BLOCK].reshape(_SIDE, _SIDE)[p0:p1 + 1, q0:q1 + 1]
        if len(block) != n or np.count_nonzero(inside) != n:
            raise ProtocolError("a mask that does not fit")
        vertices = np.frombuffer(part, "<f4", 3 * n, _MASK_BYTES).reshape(n, 3)
        triangles = np.frombuffer(part, "<u2", -1, _MASK_BYTES + 12 * n).reshape(-1, 3)
        if triangles.max() >= n:
            raise ProtocolError("a triangle of a vertex that is not there")
        return block, vertices, triangles

    def _codes_q16(self, chunk: _Chunk) -> Tuple[Any, int]:
        n = chunk.rows * chunk.cols
        n_bytes = (3 * n + 7) // 8
        if len(chunk.part) < n_bytes or (3 * n % 8 and chunk.part[n_bytes - 1] >> 3 * n % 8):
            raise ProtocolError("cell codes that do not fit")
        three = np.zeros(((n + 7) // 8, 3), np.uint16)
        three.reshape(-1)[:n_bytes] = np.frombuffer(chunk.part, np.uint8, n_bytes)
        twelve = np.empty((len(three), 2), np.uint16)
        twelve[:, 0] = three[:, 0] | (three[:, 1] & 15) << 8
        twelve[:, 1] = three[:, 1] >> 4 | three[:, 2] << 4
        return _at(_FOUR_CODES, twelve).reshape(-1)[:n], n_bytes

    def _codes_delta(self, chunk: _Chunk) -> Tuple[Any, int]:
        bits = _bits(chunk.part[:_MAX_CODE_BYTES])
        starts, end = _find_groups(bits, chunk.rows, chunk.cols)
        n_bytes = _bytes_of_bits(bits, end)
        padded = np.frombuffer(bits + bytes(32), np.uint8)
        at = np.array(starts)
        first, second, third = _at(padded, at), _at(padded, at + 1), _at(padded, at + 2)
        codes = np.where(first & second, 0, 3).astype(np.uint8).repeat(8).reshape(-1, 8)
        mixed = np.flatnonzero(first & ~second & 1)
        codes[mixed] += 3 * _at(padded, at[mixed, None] + np.arange(2, 10))
        told = np.flatnonzero(first & second & third)
        three = _at(padded, at[told, None] + np.arange(3, 27)).reshape(-1, 8, 3)
        codes[told] = three[:, :, 0] | three[:, :, 1] << 1 | three[:, :, 2] << 2
        return codes.reshape(chunk.rows, -1)[:, :chunk.cols].reshape(-1), n_bytes

    def _topology(self, chunk: _Chunk, codes: Any, struts: List[Any]) -> Tuple[Any, Any]:
        if codes.max() > 6:
            raise ProtocolError("a cell of code 7")
        size = (chunk.rows, chunk.cols)
        first = self._first_corners.get(size)
        if first is None:
            first = (_SIDE * np.arange(1, size[0] + 1)[:, None] + np.arange(1, size[1] + 1))
            first = self._first_corners[size] = first.reshape(-1, 1).astype(np.uint16)
        corners = (_at(_CORNERS[int(self.stream.flip)], codes) + first).reshape(-1, 3)
        triangles = _at(corners, np.flatnonzero(_at(_HAS_TRIANGLE, codes)))
        if struts:
            triangles = np.concatenate([triangles, np.array(struts, np.uint16)])
        used = np.zeros(_BLOCK, bool)
        used[triangles.reshape(-1).astype(np.intp)] = True
        block = np.flatnonzero(used)
        if len(block) != chunk.n_vertices or len(triangles) != chunk.n_triangles:
            raise ProtocolError("a chunk whose counts are not those of its codes")
        rank = np.cumsum(used, dtype=np.uint16) - np.uint16(1)
        return block, _at(rank, triangles)

    def _residuals(self, chunk: _Chunk, at: int) -> Any:
        n = chunk.n_vertices
        data = bytes(chunk.part[at:])
        bits = _bits(data)
        starts, widths, end = _find_blocks(bits, n)
        if 8 * _bytes_of_bits(bits, end) != len(bits):
            raise ProtocolError("a chunk of another length")
        width = np.array(widths)[:, None]
        first_bit = np.array(starts)[:, None] + np.arange(32) * width
        # eight bytes from each byte on, as one number
        words = np.ndarray(len(data) + 1, "<i8", data + bytes(9), strides=(1,))
        z = words.take(first_bit >> 3, mode="clip") >> (first_bit & 7) & ((1 << width) - 1)
        return ((z >> 1) ^ -(z & 1)).astype(np.uint32).reshape(-1)[:n]

    def _points(self, chunk: _Chunk, block: Any, ranges: Any) -> Any:
        stream, tables = self.stream, self.tables
        row0, col0, width = 64 * chunk.key[0] - 1, 64 * chunk.key[1] - 1, stream.width
        rows = _at(_BLOCK_ROW, block) + row0
        cols = _at(_BLOCK_COL, block) + col0
        if stream.wrap:
            cols %= width
        points = np.empty((len(block), 3), np.float32)
        with np.errstate(all="ignore"):
            r = ranges.astype(np.float32) * np.float32(stream.unit_m)
            if stream.model == "pinhole":
                points[:, 0] = r * _at(tables[:width], cols)
                points[:, 1] = r * _at(tables[width:], rows)
                points[:, 2] = r
            elif stream.model == "table":
                np.multiply(r[:, None], _at(tables.reshape(-1, 3), rows * width + cols), points)
            else:
                c, s = _at(tables[:2 * width].reshape(-1, 2), cols).T
                dx, dy, dz, ox, oy, oz = _at(tables[2 * width:].reshape(-1, 6), rows).T
                u, v = ox + r * dx, oy + r * dy
                points[:, 0] = u * c - v * s
                points[:, 1] = u * s + v * c
                points[:, 2] = oz + r * dz
        points.flags.writeable = False
        return points


def _sum_up(tiles: Sequence[_Delta], predictor: int) -> List[Any]:
    """Ranges of delta tiles that have one predictor, by waves: each wave is the vertices, of all
    tiles, whose expected ranges are known after the waves before."""
    n_tiles, side = len(tiles), _SIDE + 1
    # a row above each block and a column before it, without vertices
    used = np.zeros((n_tiles, side, side), bool)
    for i, tile in enumerate(tiles):
        used[i].reshape(-1)[_BLOCK_ROW[tile.block] * side + _BLOCK_COL[tile.block] + side + 1] = True
    flat = used.reshape(-1)
    at = np.flatnonzero(flat)
    n = len(at)
    wave = _waves(used)[at // side] + (at % side).astype(np.uint16)
    order = np.argsort(wave, kind="stable")

    # slots of values: a 0, the start of each tile, then the vertices in the order of their waves
    slot = np.empty(n, np.intp)
    slot[order] = np.arange(n) + (1 + n_tiles)
    nth = np.cumsum(flat, dtype=np.intp) - 1
    w, north, nw = (_at(flat, at - back) for back in (1, side, side + 1))
    slots = [_at(slot, _at(nth, at - back)) for back in (1, side, side + 1)]
    counts = np.array([len(tile.block) for tile in tiles])
    before = np.concatenate([[0], slot[:-1]])
    before[np.concatenate([[0], np.cumsum(counts)[:-1]])] = 1 + np.arange(n_tiles)
    one = np.where(w, slots[0], np.where(north, slots[1], before))
    three = w & north & nw
    # where not all three are there, the others are such that `expected` comes out as the one
    other = 0 if predictor == 0 else one
    iw = _at(one, order)
    inorth = _at(np.where(three, slots[1], other), order)
    inw = _at(np.where(three, slots[2], other), order)

    values = np.zeros(1 + n_tiles + n, np.uint32)
    values[1:1 + n_tiles] = [tile.start for tile in tiles]
    residuals = np.concatenate([tile.residuals for tile in tiles])[order]
    begin = 0
    for size in np.bincount(wave).tolist():
        end = begin + size
        if size:
            expected = _at(values, iw[begin:end])
            if predictor == 0:
                expected += _at(values, inorth[begin:end])
                expected -= _at(values, inw[begin:end])
            elif predictor == 1:
                b = _at(values, inorth[begin:end])
                expected = (expected & b) + ((expected ^ b) >> np.uint32(1))
            elif predictor == 3:
                b, c = _at(values, inorth[begin:end]), _at(values, inw[begin:end])
                low, high = np.minimum(expected, b), np.maximum(expected, b)
                expected = np.where(c >= high, low, np.where(c <= low, high, expected + b - c))
            values[1 + n_tiles + begin:1 + n_tiles + end] = expected + residuals[begin:end]
            begin = end
    return np.split(_at(values, slot), np.cumsum(counts)[:-1])


def _waves(used: Any) -> Any:
    """For each row of all tiles the wave of its first column; each column is a wave later.

    A vertex waits for those to its left and above. The first of a row that has none above waits
    for the last of the rows before, wherever that is.
    """
    n_tiles, side, _ = used.shape
    some = used.any(axis=2)
    first = used.argmax(axis=2)
    last = side - 1 - used[:, :, ::-1].argmax(axis=2)
    waves = np.zeros((n_tiles, side), np.uint16)
    last_before = np.zeros(n_tiles, np.intp)
    tile = np.arange(n_tiles)
    for p in range(1, side):
        alone = some[:, p] & ~used[tile, p - 1, first[:, p]]
        step = np.where(alone, np.maximum(1, last_before - first[:, p] + 1), 1)
        waves[:, p] = waves[:, p - 1] + step
        last_before = np.where(some[:, p], last[:, p], last_before)
    return waves.reshape(-1)


# ---------------------------------------------------------------------------------- the connection


def _split_text(body: memoryview, at: int, what: str) -> str:
    """The text that fills the rest of a body. What is no UTF-8 in it (part of a file's name, a
    character that was cut) is replaced."""
    if len(body) < at + 2 or len(body) != at + 2 + (body[at] | body[at + 1] << 8):
        raise ProtocolError(f"{what}: a body of another length")
    raw = bytes(body[at + 2:])
    if any(byte < 0x20 or byte == 0x7F for byte in raw):
        raise ProtocolError(f"{what}: a text with control bytes")
    return raw.decode("utf-8", "replace")


class _Message(NamedTuple):
    type: int
    stream: int
    epoch: int
    body: memoryview


def _connect(to: socket.socket, path: str) -> None:
    if len(os.fsencode(path)) > 107:
        raise OSError(errno.ENAMETOOLONG, "a socket path has at most 107 bytes", path)
    try:
        to.connect(path)
    except OSError as error:
        if error.errno is not None:  # a timeout has none
            error.filename = path
        raise


def _words(error: BaseException) -> str:
    """What happened, for people: without the number of an OSError, with its file."""
    if isinstance(error, OSError) and error.filename is not None:
        return f"{os.fsdecode(error.filename)}: {error.strerror or error}"
    return str(error)


class _Link:
    """A connected socket, and messages through it."""

    def __init__(self, path: str, patience_s: float) -> None:
        self.patience_s = patience_s
        self.max_body = _MAX_BODY_BEFORE_WELCOME
        self._n_sent = self._n_received = 0
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.settimeout(patience_s)
            _connect(self._socket, path)
        except BaseException:
            self._socket.close()
            raise

    def close(self) -> None:
        self._socket.close()

    def shut(self) -> None:
        """Ends a read() of another thread."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass

    def send(self, kind: int, body: bytes = b"") -> None:
        header = _HEADER.pack(len(body), kind, 0, _NO_STREAM, self._n_sent, 0)
        self._n_sent = self._n_sent + 1 & 0xFFFFFFFF
        self._socket.settimeout(self.patience_s)
        try:
            self._socket.sendall(header + body)
        except socket.timeout:
            raise ConnectionLost("the server reads nothing") from None
        except OSError:
            pass  # closed: what it said before, and why, is still to be read

    def read(self, timeout: Optional[float]) -> _Message:
        """The next message that is known; TimeoutError when none begins in time. What is passed over
        meanwhile gives no more time."""
        until = None if timeout is None else time.monotonic() + timeout
        while True:
            header, deadline = self._read_header(until)
            length, kind, flags, stream, seq, epoch = _HEADER.unpack(header)
            if length > self.max_body and not self._n_received and header[:1] == b"{":
                raise ProtocolError("found a line of JSON in answer, expected WELCOME; this seems to be the control "
                                    "socket, but this needs the mesh socket (socket in the configuration)")
            if length > self.max_body:
                raise ProtocolError(f"a message of {length} bytes, where {self.max_body} are the most")
            if seq != self._n_received:
                raise ProtocolError(f"message {seq} where {self._n_received} is due")
            self._n_received = self._n_received + 1 & 0xFFFFFFFF
            body = self._read_bytes(length, deadline)
            if 1 <= kind < len(_NAMES):
                return _Message(kind, stream, epoch, body)
            if not flags & _SKIPPABLE:
                raise ProtocolError(f"a message of type {kind}")

    def _read_header(self, until: Optional[float]) -> Tuple[bytes, float]:
        self._socket.settimeout(None if until is None else max(0.001, until - time.monotonic()))
        try:
            first = self._socket.recv(_HEADER.size)
        except socket.timeout:
            raise TimeoutError("nothing from the server in time") from None
        except OSError as error:
            raise ConnectionLost(str(error)) from None
        if not first:
            raise ConnectionLost("the server closed the connection")
        deadline = time.monotonic() + self.patience_s
        if len(first) < _HEADER.size:
            first += bytes(self._read_bytes(_HEADER.size - len(first), deadline))
        return first, deadline

    def _read_bytes(self, n: int, deadline: float) -> memoryview:
        data = bytearray(n)
        view = memoryview(data)
        got = 0
        while got < n:
            left = deadline - time.monotonic()
            try:
                if left <= 0:
                    raise socket.timeout
                self._socket.settimeout(left)
                more = self._socket.recv_into(view[got:])
            except socket.timeout:
                raise ConnectionLost("the server stopped in the middle of a message") from None
            except OSError as error:
                raise ConnectionLost(str(error)) from None
            if not more:
                raise ConnectionLost("the server closed the connection in the middle of a message")
            got += more
        return view.toreadonly()


class _Wish(NamedTuple):
    """What a subscription asks for."""

    stream: str
    encoding: str
    mode: str
    attributes: bool
    normals: bool
    bound: int  # sixteenths of a sigma
    stride: int
    interval_ms: int
    region: Tuple[int, int, int, int]
    numpy: bool
    max_dexels: int


class _Session:
    """One connection's way through the states of the protocol."""

    def __init__(self, link: _Link, wish: _Wish, tell: Callable[[str, str], None]) -> None:
        self.stream: Optional[Stream] = None
        self.server = ""
        self._link = link
        self._wish = wish
        self._tell = tell
        self._number = _NO_STREAM
        self._n_allowed = 0  # pull: batches asked for that have not come
        self._state = "connected"
        self._take = {_WELCOME: self._welcome, _SUBSCRIBED: self._subscribed, _GEOMETRY: self._geometry,
                      _SNAPSHOT_BEGIN: self._snapshot_begin, _TILE: self._tile, _COMMIT: self._commit,
                      _SNAPSHOT_END: self._snapshot_end, _STREAM_STATE: self._stream_state,
                      _RESET: self._reset, _ERROR: self._error}
        self._forget()
        link.send(_HELLO, _HELLO_BODY.pack(_MAGIC, *VERSION, 0, 7))

    def _forget(self) -> None:
        self._tables = bytearray()
        self._decoder: Any = None
        self._tiles: Dict[Key, Tile] = {}
        self._fresh = True
        self._last_epoch = -1
        self._close_batch()

    def _close_batch(self) -> None:
        self._batch: Dict[Key, Any] = {}
        self._batch_epoch = -1

    def next_mesh(self, timeout: Optional[float]) -> Optional[Mesh]:
        """Reads until a COMMIT; None: the stream has ended."""
        while True:
            if self._wish.mode == "pull" and not self._n_allowed and self._state not in ("connected",):
                self._link.send(_NEXT)
                self._n_allowed += 1
            due = self._state in ("connected", "geometry", "tiles", "committed") or self._batch_epoch >= 0
            try:
                message = self._link.read(self._link.patience_s if due else timeout)
            except TimeoutError:
                if due:
                    raise ConnectionLost(f"the server fell silent ({self._state})") from None
                raise
            take = self._take.get(message.type)
            name = _NAMES[message.type]
            if take is None:
                raise ProtocolError(f"{name} from a server")
            about = message.type not in (_WELCOME, _ERROR)
            if (message.stream == _NO_STREAM) == about:
                raise ProtocolError(f"{name} about stream {message.stream:#x}")
            if about:
                if self._number not in (_NO_STREAM, message.stream):
                    raise ProtocolError(f"{name} about another stream")
                self._number = message.stream
            result = take(message)
            if isinstance(result, Mesh):
                return result
            if result == "ended":
                return None

    def _expect(self, message: _Message, *states: str, size: Optional[int] = None) -> None:
        if self._state not in states:
            raise ProtocolError(f"{_NAMES[message.type]} where none may come ({self._state})")
        if size is not None and len(message.body) != size:
            raise ProtocolError(f"{_NAMES[message.type]} of {len(message.body)} bytes")

    def _welcome(self, message: _Message) -> None:
        self._expect(message, "connected")
        if len(message.body) < 24:
            raise ProtocolError(f"WELCOME of {len(message.body)} bytes")
        magic, major, minor, _, encodings, max_body, _ = _WELCOME_BODY.unpack_from(message.body)
        if magic != _MAGIC or max_body > _MAX_BODY:
            raise ProtocolError("WELCOME of no dexeld")
        if major != VERSION[0] or minor > VERSION[1]:
            raise ProtocolError("the server speaks version %d.%d, this client %d.%d" % (major, minor, *VERSION))
        wish = self._wish
        encoding = ENCODINGS.index(wish.encoding)
        if not encodings >> encoding & 1:
            raise ProtocolError(f"the server does not offer {wish.encoding}")
        self.server = _split_text(message.body, 24, "WELCOME")
        self._link.max_body = max_body
        self._state = "welcomed"
        name = wish.stream.encode()
        self._link.send(_SUBSCRIBE, _SUBSCRIBE_BODY.pack(
            encoding, MODES.index(wish.mode), wish.attributes + 2 * wish.normals, wish.stride,
            wish.interval_ms, *wish.region, wish.bound) + struct.pack("<H", len(name)) + name)

    def _subscribed(self, message: _Message) -> None:
        self._expect(message, "welcomed")
        self.stream = _read_subscribed(message.body, self._wish)
        if self._wish.encoding == "f32":
            self._begin_tiles()
        else:
            self._state = "geometry"

    def _geometry(self, message: _Message) -> None:
        self._expect(message, "geometry")
        n = len(message.body) - 8
        if not 4 <= n <= 65536 or n % 4:
            raise ProtocolError(f"GEOMETRY of {len(message.body)} bytes")
        offset, total = struct.unpack_from("<II", message.body)
        due = self.stream.table_bytes
        if offset != len(self._tables) or total != due or offset + n > due:
            raise ProtocolError(f"GEOMETRY {offset} + {n} of {total}, where {len(self._tables)} of {due} are there")
        self._tables += message.body[8:]
        if len(self._tables) == due:
            self._begin_tiles()

    def _begin_tiles(self) -> None:
        self._decoder = (_Arrays if self._wish.numpy else _Lists)(self.stream, bytes(self._tables))
        self._tables = bytearray()
        self._state = "snapshot"

    def _snapshot_begin(self, message: _Message) -> None:
        self._expect(message, "snapshot", size=0)
        self._batch_epoch = message.epoch
        self._state = "tiles"

    def _tile(self, message: _Message) -> None:
        self._expect(message, "tiles", "live")
        if self._batch_epoch < 0:
            self._batch_epoch = message.epoch
        if message.epoch != self._batch_epoch or message.epoch <= self._last_epoch:
            raise ProtocolError(f"TILE of epoch {message.epoch}")
        key, chunk = _read_chunk(message.body, self.stream, self._wish.region)
        if key in self._batch:
            raise ProtocolError(f"tile {key} twice in a batch")
        self._batch[key] = None if chunk is None else self._decoder.decode(chunk)

    def _commit(self, message: _Message) -> Mesh:
        self._expect(message, "tiles", "live", size=44)
        commit = _COMMIT_BODY.unpack(message.body)
        if (self._batch_epoch >= 0 and message.epoch != self._batch_epoch) or message.epoch <= self._last_epoch:
            raise ProtocolError(f"COMMIT of epoch {message.epoch}")
        if commit[5] != len(self._batch):
            raise ProtocolError(f"COMMIT of {commit[5]} tiles after {len(self._batch)}")
        if commit[4] not in CLOCKS:
            raise ProtocolError(f"COMMIT with clock {commit[4]}")
        tiles = dict(self._tiles)
        changed = set()
        for key, tile in self._batch.items():
            if tile is None and tiles.pop(key, None) is not None:
                changed.add(key)
        for tile in self._decoder.finish([tile for tile in self._batch.values() if tile is not None]):
            tiles[tile.row, tile.col] = tile
            changed.add((tile.row, tile.col))
        self._close_batch()
        self._tiles = tiles
        self._last_epoch = message.epoch
        self._state = "committed" if self._state == "tiles" else "live"
        self._n_allowed = max(0, self._n_allowed - 1)
        fresh, self._fresh = self._fresh, False
        return Mesh(self.stream, message.epoch, commit, tiles, frozenset(changed), fresh)

    def _snapshot_end(self, message: _Message) -> None:
        self._expect(message, "committed", size=0)
        if message.epoch != self._last_epoch:
            raise ProtocolError(f"SNAPSHOT_END of epoch {message.epoch}")
        self._state = "live"

    def _stream_state(self, message: _Message) -> Optional[str]:
        if self._state == "connected" or self._batch:
            raise ProtocolError("STREAM_STATE where none may come")
        if not message.body or message.body[0] >= len(STATES):
            raise ProtocolError("STREAM_STATE of no state")
        state = STATES[message.body[0]]
        reason = _split_text(message.body, 1, "STREAM_STATE")
        self._tell(state, reason)
        if state == "ended" and reason:
            raise StreamFailed(reason)
        return state

    def _reset(self, message: _Message) -> None:
        if self._state == "connected":
            raise ProtocolError("RESET before WELCOME")
        _split_text(message.body, 0, "RESET")
        self._forget()
        self._state = "welcomed"

    def _error(self, message: _Message) -> None:
        if len(message.body) < 2:
            raise ProtocolError("ERROR without a code")
        text = _split_text(message.body, 2, "ERROR")
        raise ServerError(message.body[0] | message.body[1] << 8, text)


def _read_subscribed(body: memoryview, wish: _Wish) -> Stream:
    if len(body) < 178:
        raise ProtocolError(f"SUBSCRIBED of {len(body)} bytes")
    name = _split_text(body, 178, "SUBSCRIBED")
    (encoding, mode, attr_bytes, model, wrap, flip, range_bytes, diag, paper, normals, smooth, stride,
     height, width, tile_rows, tile_cols, unit_m, table_bytes, *rest) = _SUBSCRIBED_BODY.unpack_from(body)
    numbers, bound = rest[:-1], rest[-1]
    bits = (wrap, flip, paper, normals, smooth)
    if (max(bits) > 1 or model not in MODELS or range_bytes not in (2, 4) or diag > 2 or attr_bytes > 2
            or not 2 <= height <= 65535 or not (8 if wrap else 2) <= width <= 65535
            or not all(map(math.isfinite, [unit_m, *numbers])) or unit_m <= 0
            or (tile_rows, tile_cols) != ((height + 62) // 64, (width + 62 + wrap) // 64)):
        raise ProtocolError("SUBSCRIBED with a value that cannot be")
    if height * width > wish.max_dexels:
        raise ProtocolError(f"a stream of {height} x {width} dexels, where {wish.max_dexels} are the most")
    if (ENCODINGS.index(wish.encoding), MODES.index(wish.mode), wish.stride, wish.bound) != \
            (encoding, mode, stride, bound) or (attr_bytes and not wish.attributes) or normals > wish.normals \
            or (wish.stream and wish.stream != name) or (wish.encoding == "q16" and range_bytes != 2):
        raise ProtocolError("SUBSCRIBED is not what was asked for")
    tables = {1: 4 * (2 * width + 6 * height), 2: 4 * (width + height), 3: 12 * height * width}[model]
    if table_bytes != (0 if wish.encoding == "f32" else tables):
        raise ProtocolError(f"SUBSCRIBED with tables of {table_bytes} bytes")
    pose = tuple(tuple(numbers[4 * i:4 * i + 4]) for i in range(3))
    return Stream(name, wish.encoding, wish.mode, attr_bytes, MODELS[model], bool(wrap), bool(flip), range_bytes,
                  diag, bool(paper), bool(normals), bool(smooth), stride, height, width, tile_rows, tile_cols,
                  unit_m, table_bytes, pose, tuple(numbers[12:15]), *numbers[15:18], bound / 16)


def _read_chunk(body: memoryview, stream: Stream, region: Tuple[int, int, int, int]) -> Tuple[Key, Optional[_Chunk]]:
    """A TILE's key and chunk; None: the tile is empty."""
    if len(body) < _CHUNK.size:
        raise ProtocolError(f"TILE of {len(body)} bytes")
    row, col, encoding, sections, n, n_triangles = _CHUNK.unpack_from(body)
    row0, col0, n_rows, n_cols = region
    if (row >= stream.tile_rows or col >= stream.tile_cols or
            (n_rows and not (row0 <= row < row0 + n_rows and col0 <= col < col0 + n_cols))):
        raise ProtocolError(f"tile ({row}, {col}), which there is none")
    if encoding != ENCODINGS.index(stream.encoding):
        raise ProtocolError(f"a chunk of encoding {encoding}")
    if n == n_triangles == 0:
        if sections or len(body) != _CHUNK.size:
            raise ProtocolError("an empty chunk with something in it")
        return (row, col), None
    if not 3 <= n <= _BLOCK or not 1 <= n_triangles <= _MAX_TRIANGLES:
        raise ProtocolError(f"a chunk of {n} vertices and {n_triangles} triangles")
    if sections != stream.attr_bytes + 4 * stream.normals + 8 * stream.smooth:
        raise ProtocolError(f"a chunk with sections {sections:#x}")
    begin = _CHUNK.size + stream.attr_bytes * n
    end = len(body) - 2 * n * stream.normals
    if end < begin or (stream.encoding == "f32" and end - begin != _MASK_BYTES + 12 * n + 6 * n_triangles):
        raise ProtocolError("a chunk of another length")
    row_first, col_first = 64 * row - 1, 64 * col - 1  # of block dexel (0, 0)
    block_cols = (0, _SIDE - 1)
    if not stream.wrap:
        block_cols = (max(0, -col_first), min(_SIDE - 1, stream.width - 1 - col_first))
    return (row, col), _Chunk(
        (row, col), n, n_triangles, min(64, stream.height - 1 - 64 * row),
        min(64, stream.width - (not stream.wrap) - 64 * col),
        (max(0, -row_first), min(_SIDE - 1, stream.height - 1 - row_first)), block_cols,
        body[_CHUNK.size:begin] if stream.attr_bytes else None, body[begin:end],
        body[end:] if stream.normals else None)


# ------------------------------------------------------------------------------- the subscription


class Subscription(Iterator[Mesh]):
    """An iterator over the meshes of a stream; see subscribe()."""

    def __init__(self, path: str, wish: _Wish, timeout: Optional[float], reconnect: bool, wait: bool,
                 on_state: Optional[Callable[[str, str], None]]) -> None:
        self.path = path
        #: As SUBSCRIBED told it last; None before.
        self.stream: Optional[Stream] = None
        #: Name and version of the service; empty before it is known.
        self.server = ""
        #: The stream's state and the reason for it, as told last.
        self.state = "opening"
        self.reason = ""
        self._wish = wish
        self._timeout = timeout
        self._reconnect = reconnect
        self._on_state = on_state
        self._link: Optional[_Link] = None
        self._session: Optional[_Session] = None
        self._closed = threading.Event()
        self._pause_s = 0.0
        self._is_away = False  # the service, and on_state was told so
        self._keys: FrozenSet[Key] = frozenset()
        if not wait:
            self._connect()

    def __enter__(self) -> Subscription:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __iter__(self) -> Iterator[Mesh]:
        return self

    def __next__(self) -> Mesh:
        waiting_since = time.monotonic()
        while not self._closed.is_set():
            try:
                if self._session is None:
                    self._connect()
                mesh = self._session.next_mesh(self._timeout)
            except TimeoutError:
                raise
            except (ConnectionLost, ServerError, ConnectionRefusedError, FileNotFoundError, BlockingIOError) as error:
                if self._closed.is_set():
                    break
                self._drop()
                if not self._reconnect or (isinstance(error, ServerError) and error.code not in error.PASSING):
                    self.close()
                    raise
                try:
                    self._lose(error)
                except BaseException:  # of on_state
                    self.close()
                    raise
                self._pause(waiting_since, error)
                continue
            except BaseException:
                self.close()
                raise
            self._is_away = False
            self.stream = self._session.stream
            if mesh is None:
                break
            self._pause_s = 0.0
            if mesh.fresh:
                mesh.changed |= self._keys
            self._keys = frozenset(mesh.tiles)
            return mesh
        self.close()
        raise StopIteration

    def close(self) -> None:
        """Ends the subscription, also one that another thread waits for."""
        self._closed.set()
        link = self._link
        if link is not None:
            link.shut()
        self._drop()

    def _drop(self) -> None:
        link, self._link, self._session = self._link, None, None
        if link is not None:
            link.close()

    def _connect(self) -> None:
        patience = PATIENCE_S if self._timeout is None else min(PATIENCE_S, self._timeout)
        self._link = _Link(self.path, patience)
        self._session = _Session(self._link, self._wish, self._hear)

    def _lose(self, error: Exception) -> None:
        """There is no connection: told once, until the next one says something of the stream."""
        if not self._is_away:
            self._is_away = True
            self._tell("gone", _words(error))

    def _pause(self, waiting_since: float, error: Exception) -> None:
        """Waits a while before another attempt, and longer before the next."""
        self._pause_s = min(5.0, 2 * self._pause_s or 0.1)
        if self._timeout is not None and time.monotonic() + self._pause_s > waiting_since + self._timeout:
            raise TimeoutError(f"no service in {self._timeout} s: {_words(error)}") from None
        self._closed.wait(self._pause_s)

    def _hear(self, state: str, reason: str) -> None:
        self._is_away = False
        self._tell(state, reason)

    def _tell(self, state: str, reason: str) -> None:
        self.state, self.reason = state, reason
        if self._on_state is not None:
            self._on_state(state, reason)


def subscribe(path: Optional[str] = None, stream: str = "", *, encoding: str = "f32", mode: str = "live",
              attributes: bool = True, normals: bool = False, bound: float = 0, stride: int = 0,
              interval: float = 0, region: Optional[Tuple[int, int, int, int]] = None,
              reconnect: bool = True, wait: bool = False, timeout: Optional[float] = None,
              on_state: Optional[Callable[[str, str], None]] = None, numpy: Optional[bool] = None,
              max_dexels: int = _MAX_DEXELS) -> Subscription:
    """Subscribes to a stream and returns an iterator over its meshes, one for each COMMIT.

    path         the mesh socket; default DEXELD_SOCKET of the environment, or /run/dexeld/mesh.sock
    stream       its name; not needed where there is only one
    encoding     "f32"; "q16" and "delta" are smaller on the way and give the same mesh
    mode         "live"; "pull": the service makes a mesh when the loop comes back for one, and none
                 before; "lossless": every epoch, of a replay at rate max
    attributes, normals   whether to ask for them, where the stream has them
    bound, stride         a level of detail (f32 alone): in sigmas, to a sixteenth; in cells
    interval     live: least seconds between two meshes
    region       (first tile row, first tile column, tile rows, tile columns); default all
    reconnect    whether to connect again when the service goes away, is full or has thrown this client
                 out because it was too slow
    wait         whether to wait also for a service that is not there at first
    timeout      seconds without a word from the service after which TimeoutError is raised; the
                 loop can be taken up again after it. None: never
    on_state     called with (state, reason) when the stream says how it is: opening, live, stalled,
                 gone, faulted, ended; and with ("gone", why) when the service itself has gone and is
                 waited for
    numpy        False: lists also where numpy is there
    max_dexels   refuse a larger stream: a bound on memory against a server that is not trusted

    The iterator ends when a replay has ended. It raises ServerError when the service refuses,
    ProtocolError when it talks nonsense, StreamFailed when the source failed for good, ConnectionLost
    (only without reconnect) and OSError when there is no way to it.
    """
    if encoding not in ENCODINGS or mode not in MODES:
        raise ValueError(f"no encoding {encoding!r} or no mode {mode!r}")
    if numpy and np is None:
        raise ValueError("numpy is not there")
    sixteenths = round(bound * 16)
    if (bound and not 1 <= sixteenths <= 65534) or stride not in (0, 2, 4, 8, 16, 32, 64):
        raise ValueError(f"no level of detail: bound {bound}, stride {stride}")
    area = region or (0, 0, 0, 0)
    if len(area) != 4 or not all(0 <= n <= 65535 for n in area) or bool(area[2]) != bool(area[3]):
        raise ValueError(f"no region: {region}")
    name = stream.encode()
    if len(name) > 63 or any(byte < 0x20 or byte == 0x7F for byte in name):
        raise ValueError(f"no name of a stream: {stream!r}")
    interval_ms = round(interval * 1000)
    if not 0 <= interval_ms <= 0xFFFFFFFF:
        raise ValueError(f"no interval: {interval}")
    wish = _Wish(stream, encoding, mode, attributes, normals, sixteenths, stride, interval_ms, tuple(area),
                 np is not None and numpy is not False, min(max_dexels, _MAX_DEXELS))
    return Subscription(path or os.environ.get("DEXELD_SOCKET") or DEFAULT_SOCKET, wish, timeout, reconnect,
                        wait, on_state)


def streams(path: Optional[str] = None) -> List[Dict[str, Any]]:
    """The streams of a service, as its control socket tells them (docs/control.md): dicts with at
    least "name" and "state".

    path is a control socket, or a mesh socket that has its control socket beside it as PATH.control;
    default DEXELD_CONTROL of the environment, or /run/dexeld/control.sock.
    """
    path = path or os.environ.get("DEXELD_CONTROL") or DEFAULT_CONTROL
    if os.path.exists(path + ".control"):
        path += ".control"
    answer = b""
    deadline = time.monotonic() + 5
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as control:
        control.settimeout(5)
        _connect(control, path)
        # as long as a header, so that a mesh socket refuses it at once and waits for no more
        try:
            control.sendall(b'{"request":"status"}'.ljust(_HEADER.size) + b"\n")
        except (BrokenPipeError, ConnectionResetError):
            pass  # what it said and went is still to be read
        while not answer.endswith(b"\n"):
            control.settimeout(max(0.001, deadline - time.monotonic()))
            try:
                more = control.recv(65536)
            except socket.timeout:
                raise ConnectionLost(f"{path}: no answer") from None
            except ConnectionResetError:
                more = b""
            if not more:
                raise ConnectionLost(f"{path}: closed without an answer")
            answer += more
            if not answer.startswith(b"{"):
                raise ProtocolError(f"{path}: found no JSON line in answer, expected one; this seems to be the mesh "
                                    "socket, but this needs the control socket (control_socket in the configuration)")
            if len(answer) > _MAX_CONTROL:
                raise ProtocolError(f"{path}: an answer without an end")
    try:
        found = json.loads(answer)["streams"]
        if not all(isinstance(one["name"], str) for one in found):
            raise TypeError
    except (ValueError, KeyError, TypeError):
        raise ProtocolError(f"{path}: no answer of dexeld") from None
    return found


# ------------------------------------------------------------------------------------ the program


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, as `dexel` does."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message.removeprefix('argument ')}\n")


def _found(text: str, expected: str) -> argparse.ArgumentTypeError:
    return argparse.ArgumentTypeError(f"found '{text}', expected {expected}")


def _number(kind: Callable[[str], float], least: float, most: float, what: str) -> Callable[[str], float]:
    def read(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not least <= value <= most:
            raise _found(text, f"{what} from {least} to {most}")
        return value
    return read


def _choice(*choices: Union[str, int]) -> Callable[[str], Union[str, int]]:
    def read(text: str) -> Union[str, int]:
        for choice in choices:
            if text == str(choice):
                return choice
        raise _found(text, "|".join(map(str, choices)))
    return read


def _region(text: str) -> Tuple[int, ...]:
    parts = text.split(",")
    if all(part.isascii() and part.isdigit() and len(part) <= 5 for part in parts):
        area = tuple(map(int, parts))
        if len(area) == 4 and max(area) <= 65535 and area[2] and area[3]:
            return area
    raise _found(text, "R,C,ROWS,COLS: the first tile's row and column, and how many, at most 65535 each")


def _ply(text: str) -> str:
    if not text.lower().endswith(".ply"):
        raise _found(text, "a name that ends in .ply")
    return text


def _numbered(path: str, number: int) -> str:
    """path with the number where %06d stands, else before its extension."""
    head, mark, tail = path.partition("%06d")
    if not mark:
        head, tail = path[:-len(".ply")] + "-", path[-len(".ply"):]
    return f"{head}{number:06d}{tail}"


def _arguments() -> argparse.Namespace:
    parser = _Parser(prog="dexel.py", description="Receives meshes from dexeld: a line for each, and PLY files. What the "
                     "service says of the stream, and when it goes away, is told on standard error.")
    add = parser.add_argument
    add("--socket", metavar="PATH", help=f"the mesh socket ({DEFAULT_SOCKET})")
    add("--list", action="store_true", help="list the streams (--socket: also the control socket) and end")
    add("--stream", metavar="NAME", default="", help="not needed where there is only one")
    add("--encoding", metavar="|".join(ENCODINGS), type=_choice(*ENCODINGS), default="f32",
        help="how the mesh travels (f32)")
    add("--lod", metavar="SIGMAS", type=_number(float, 0.0625, 4095.875, "sigmas"), default=0,
        help="level of detail, in sigmas of the noise")
    add("--stride", metavar="N", type=_choice(2, 4, 8, 16, 32, 64), default=0,
        help="level of detail, in cells: 2, 4 ... 64")
    add("--region", metavar="R,C,ROWS,COLS", type=_region, help="only these tiles")
    add("--no-attr", action="store_true", help="do not ask for attributes")
    add("--normals", action="store_true", help="ask for normals")
    add("--frames", metavar="N", type=_number(int, 1, 1000000000, "commits"), help="end after so many commits")
    add("--lossless", action="store_true", help="receive every epoch (replay at rate max)")
    add("--pull", action="store_true", help="ask for each mesh")
    add("--interval", metavar="MS", type=_number(float, 0, 3600000, "milliseconds"), default=0,
        help="at most one mesh in so many milliseconds")
    add("--timeout", metavar="SECONDS", type=_number(float, 0.001, 1000000, "seconds"),
        help="give up after so long without a word")
    add("--wait", action="store_true", help="wait for a service that is not there yet")
    add("--no-reconnect", action="store_true", help="end when the connection ends")
    add("--no-numpy", action="store_true", help="do without numpy")
    add("-o", metavar="OUT.ply", dest="out", type=_ply, help="write the last mesh")
    add("--every", action="store_true",
        help="write each mesh; its number stands where OUT has %%06d, else before .ply")
    add("--quiet", action="store_true", help="print no line for a mesh")
    arguments = parser.parse_args()
    if arguments.every and not arguments.out:
        parser.error("--every needs -o")
    if arguments.lossless and arguments.pull:
        parser.error("--lossless and --pull do not go together")
    return arguments


def _run(arguments: argparse.Namespace) -> None:
    if arguments.list:
        for stream in streams(arguments.socket):
            print(stream["name"], stream.get("state", ""), stream.get("reason", ""))
        return
    meshes = subscribe(
        arguments.socket, arguments.stream, encoding=arguments.encoding,
        mode="lossless" if arguments.lossless else "pull" if arguments.pull else "live",
        attributes=not arguments.no_attr, normals=arguments.normals, bound=arguments.lod,
        stride=arguments.stride, interval=arguments.interval / 1000, region=arguments.region,
        reconnect=not arguments.no_reconnect, wait=arguments.wait, timeout=arguments.timeout,
        numpy=False if arguments.no_numpy else None,
        on_state=lambda state, reason: print(f"{state}: {reason}" if reason else state, file=sys.stderr))
    with meshes:
        mesh = None
        for n, mesh in enumerate(meshes):
            if not arguments.quiet:
                print(f"epoch {mesh.epoch}, frame {mesh.frame}: {len(mesh.changed)} tiles changed, "
                      f"{mesh.n_triangles} triangles", flush=True)
            if arguments.every:
                mesh.write_ply(_numbered(arguments.out, n))
            if n + 1 == arguments.frames:
                break
        if mesh is not None and arguments.out and not arguments.every:
            mesh.write_ply(arguments.out)


def main() -> int:
    """The program; returns its exit status."""
    arguments = _arguments()
    try:
        _run(arguments)
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # whoever read is gone: no word more
        return 1
    except (Error, OSError, ValueError) as error:
        print(f"dexel.py: {_words(error)}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
