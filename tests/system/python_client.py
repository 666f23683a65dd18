"""Tests of client/python/dexel.py that python_client.sh runs, each with numpy (where it is there) and without.

    same A.ply B.ply...     PLY files have the same vertices and triangles
    worked                  the bytes at the end of docs/protocol.md
    lies                    a server that lies: an error in words, and no hang
    passing                 one that has no room, then goes, then is there
    damage SOCKET STREAM    what the service says, cut off and changed at many places
    tiles SOCKET STREAM..   what a subscription hands out, mesh after mesh; a stream for each way
    restart SOCKET          follows a service that goes and comes back
    table OUT.pcd [W H]     a scan whose beams follow no model
"""
import math
import os
import random
import socket
import struct
import sys
import tempfile
import threading

import dexel

KINDS = [False] if dexel.np is None else [False, True]
NO_STREAM = 0xFFFFFFFF
WELCOME, ERROR, SUBSCRIBE, SUBSCRIBED, GEOMETRY, TILE, COMMIT, RESET, BEGIN, END, STATE = range(2, 13)


def check(right, what):
    if not right:
        sys.exit(f"python_client: {what}")


# ------------------------------------------------------------------------------------------ meshes


def read_ply(path):
    """Columns of the vertices by name, and the bytes of the faces."""
    with open(path, "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    codes = {"float": "f", "ushort": "H", "uchar": "B"}
    names, line, n = [], "<", 0
    for words in map(str.split, head.decode().splitlines()):
        if words[:2] == ["element", "vertex"]:
            n = int(words[2])
        elif words[0] == "property" and words[1] != "list":
            names.append(words[2])
            line += codes[words[1]]
    size = n * struct.calcsize(line)
    return dict(zip(names, zip(*struct.iter_unpack(line, body[:size])))), body[size:]


def same(first, *others):
    vertices, faces = read_ply(first)
    check(len(faces) > 1000, f"{first} has hardly a triangle")
    check(others, f"{first} has nothing to be compared with")
    for other in others:
        its_vertices, its_faces = read_ply(other)
        check(faces == its_faces, f"the triangles of {first} and {other} differ")
        # the colours that `dexel cat` writes are its attribute for viewers
        for name in (vertices.keys() | its_vertices.keys()) - {"red", "green", "blue"}:
            check(vertices.get(name) == its_vertices.get(name), f"{name} of {first} and {other} differs")


def tiles(path, *names):
    for numpy, stream in zip(KINDS, names):
        before = {}
        n_kept = n = 0
        with dexel.subscribe(path, stream, mode="lossless", timeout=300, numpy=numpy) as meshes:
            for mesh in meshes:
                check(mesh.fresh == (n == 0), f"mesh {n} is fresh: {mesh.fresh}")
                changed = {key for key in mesh.tiles.keys() | before.keys()
                           if mesh.tiles.get(key) is not before.get(key)}
                check(changed == mesh.changed, f"mesh {n} says that {mesh.changed} changed, not {changed}")
                n_kept += len(mesh.tiles.keys() - changed)
                before = mesh.tiles
                n += 1
            check(meshes.state == "ended", f"the state is {meshes.state}")
        check(n > 2 and n_kept > 0, f"{n} meshes, {n_kept} tiles kept")


def restart(path):
    n_fresh = 0
    for mesh in dexel.subscribe(path, encoding="q16", timeout=300):
        if mesh.fresh:
            n_fresh += 1
            print(f"fresh {n_fresh}", flush=True)
            if n_fresh == 2:
                check(set(mesh.tiles) <= mesh.changed, "tiles of the new service are not told as changed")
                return


def table(path, width=120, height=90):
    width, height = int(width), int(height)
    chance = random.Random(7)
    with open(path, "w", encoding="ascii") as out:
        out.write(f"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {width}\n"
                  f"HEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {width * height}\nDATA ascii\n")
        for i in range(height):
            for j in range(width):
                azimuth = math.radians(0.5 * (j + chance.uniform(-0.3, 0.3)))
                elevation = math.radians(0.5 * (height / 2 - i + chance.uniform(-0.3, 0.3)))
                r = 6 + math.sin(5 * azimuth) + chance.gauss(0, 0.0005)
                if chance.random() < 0.02:
                    r = math.nan
                out.write(f"{r * math.cos(elevation) * math.cos(-azimuth)} "
                          f"{r * math.cos(elevation) * math.sin(-azimuth)} {r * math.sin(elevation)}\n")


# ------------------------------------------------------------------------------------ a fake server


class Server:
    """Says given bytes to each client, then closes; or stays silent."""

    def __init__(self, folder):
        self.path = os.path.join(folder, "fake.sock")
        self.listening = socket.socket(socket.AF_UNIX)
        self.listening.bind(self.path)
        self.listening.listen(1)

    def meet(self, said, silent, **wish):
        """The meshes that a client takes of these bytes, and its error."""
        over = threading.Event()

        def serve():
            peer, _ = self.listening.accept()
            with peer:
                try:
                    peer.sendall(said)
                    if silent:
                        over.wait(60)
                    else:
                        peer.shutdown(socket.SHUT_WR)
                    while peer.recv(4096):
                        pass
                except OSError:
                    pass  # the client had enough

        thread = threading.Thread(target=serve)
        thread.start()
        meshes, error = [], None
        try:
            with dexel.subscribe(self.path, reconnect=False, timeout=wish.pop("timeout", 300), **wish) as taken:
                meshes.extend(taken)
        except (dexel.Error, OSError) as caught:
            error = caught
        over.set()
        thread.join()
        return meshes, error


def message(kind, body=b"", *, seq=None, epoch=0, stream=None, flags=0, length=None):
    """A message whose seq, when it is None, is filled in by said()."""
    if stream is None:
        stream = NO_STREAM if kind in (WELCOME, ERROR) else 0
    return [len(body) if length is None else length, kind, flags, stream, seq, epoch, body]


def said(messages):
    out = b""
    for n, (length, kind, flags, stream, seq, epoch, body) in enumerate(messages):
        out += struct.pack("<IHHIIQ", length, kind, flags, stream, n if seq is None else seq, epoch) + body
    return out


def text(words):
    return struct.pack("<H", len(words)) + words


def welcome(**other):
    fields = {"magic": 0x4C584544, "major": 1, "minor": 0, "encodings": 7, "max_body": 262144, **other}
    return message(WELCOME, struct.pack("<IHHIIII", fields["magic"], fields["major"], fields["minor"], 0,
                                        fields["encodings"], fields["max_body"], 1) + text(b"fake"))


def subscribed(encoding, **other):
    fields = {"mode": 0, "attr_bytes": 0, "model": 2, "wrap": 0, "flip": 1, "range_bytes": 2, "diag": 0, "paper": 0,
              "normals": 0, "smooth": 0, "stride": 0, "height": 3, "width": 3, "tile_rows": 1, "tile_cols": 1,
              "unit_m": 0.001, "table_bytes": 24 if encoding else 0, "sigma": 0.0, "bound": 0, **other}
    return message(SUBSCRIBED, struct.pack("<12BIIHHfI18dH", encoding, *list(fields.values())[:17], *[0.0] * 12,
                                           fields["sigma"], *[0.0] * 5, fields["bound"]) + text(b"s"))


def geometry(offset=0, total=24, values=(-0.5, 0, 0.5, -0.5, 0, 0.5)):
    return message(GEOMETRY, struct.pack(f"<II{len(values)}f", offset, total, *values))


def commit(n_tiles=1, epoch=1, clock=0):
    return message(COMMIT, struct.pack("<4Q3I", 0, 0, 0, 0, clock, n_tiles, 0), epoch=epoch)


ENDED = message(STATE, b"\4" + text(b""))
HEADERS = ("000000000000070005 00", "000000000100070005 00", "000000000200070005 00")
MASK = bytearray(562)
for _k in (68, 69, 70, 135, 136, 137, 203):
    MASK[_k // 8] |= 1 << _k % 8
POINTS = """00 00 00 bf  00 00 00 bf  00 00 80 3f   00 00 00 00  c5 20 00 bf  c5 20 80 3f   8a 41 00 3f  8a 41 00 bf
  8a 41 80 3f   4e 62 00 bf  00 00 00 00  4e 62 80 3f   00 00 00 00  00 00 00 00  13 83 80 3f   d7 a3 00 3f
  00 00 00 00  d7 a3 80 3f   00 00 00 00  61 e5 00 3f  61 e5 80 3f"""
CORNERS = "00 00 04 00 01 00  00 00 03 00 04 00  01 00 04 00 02 00  02 00 04 00 05 00  03 00 06 00 04 00"
CHUNKS = (
    bytes.fromhex(HEADERS[0]) + bytes(MASK) + bytes.fromhex(POINTS + CORNERS),
    bytes.fromhex(HEADERS[1] + "73 00  00 00  e8 03  e9 03  ea 03  eb 03  ec 03  ed 03  ef 03"),
    bytes.fromhex(HEADERS[2] + "f9 00  00 00  00  e8 03 00 00  3f 48 06 0c"),
)
WITH_STRUT = bytes.fromhex("""00 00  00 00  01  05  08 00  06 00  00 0a 14 1e 32 3c 46 50  8c 0a  01 00  88 0d
  e8 03  e9 03  ea 03  eb 03  ed 03  ee 03  ef 03  f0 03  fc 00  fd ff  fe fe  ff fd  01 fb  02 fa  03 f9  04 f8""")


def opening(encoding, **other):
    begin = [welcome(), subscribed(encoding, **other)]
    return begin + ([geometry()] if encoding else []) + [message(BEGIN, epoch=1)]


def worked(server):
    points = list(struct.iter_unpack("<3f", bytes.fromhex(POINTS)))
    corners = list(struct.iter_unpack("<3H", bytes.fromhex(CORNERS)))
    end = [commit(), message(END, epoch=1), ENDED]
    for numpy in KINDS:
        for encoding, chunk in enumerate(CHUNKS):
            bytes_said = said(opening(encoding) + [message(TILE, chunk, epoch=1)] + end)
            meshes, error = server.meet(bytes_said, False, encoding=dexel.ENCODINGS[encoding], numpy=numpy)
            check(error is None and len(meshes) == 1, f"worked bytes, encoding {encoding}: {error}")
            tile = meshes[0].tiles[0, 0]
            check([tuple(map(float, p)) for p in tile.vertices] == points, f"vertices: {tile.vertices}")
            check([tuple(map(int, t)) for t in tile.triangles] == corners, f"triangles: {tile.triangles}")
            check([int(name) for name in tile.names] == [0, 1, 2, 3, 4, 5, 7], f"names: {tile.names}")
        bytes_said = said(opening(1, attr_bytes=1, normals=1) + [message(TILE, WITH_STRUT, epoch=1)] + end)
        meshes, error = server.meet(bytes_said, False, encoding="q16", normals=True, numpy=numpy)
        check(error is None, f"worked bytes with a strut: {error}")
        tile = meshes[0].tiles[0, 0]
        check([tuple(map(int, t)) for t in tile.triangles] ==
              [(0, 3, 1), (1, 4, 2), (3, 5, 6), (4, 6, 7), (1, 3, 6), (1, 6, 4)], f"of a strut: {tile.triangles}")
        check(list(tile.attributes) == [0, 10, 20, 30, 50, 60, 70, 80], f"attributes: {tile.attributes}")
    normal = {(40, -28): "3f05b5ec bebb31e4 3f453923", (-100, 90): "bef33639 3eb17a9a bf4f0f08"}
    for (a, b), bits in normal.items():
        expected = struct.unpack(">3f", bytes.fromhex(bits))
        check(dexel._normal(a, b) == expected, f"normal {a}, {b}: {dexel._normal(a, b)}")
        if dexel.np is not None:
            found = tuple(map(float, dexel._normal_table()[a & 255 | (b & 255) << 8]))
            check(found == expected, f"normal {a}, {b} of the table: {found}")


def lies_of_messages():
    """(expected words, what is said, encoding) about messages."""
    tile = message(TILE, CHUNKS[1], epoch=1)
    yield "262144 are the most", [welcome(), message(SUBSCRIBED, length=262145)], 1
    yield "1024 are the most", [message(WELCOME, length=1025)], 1
    yield "100 are the most", [welcome(max_body=100), subscribed(1)], 1
    yield "of no dexeld", [welcome(magic=1)], 1
    yield "of no dexeld", [welcome(max_body=1 << 20)], 1
    yield "version 1.1", [welcome(minor=1)], 1
    yield "version 0.3", [welcome(major=0, minor=3)], 1
    yield "does not offer q16", [welcome(encodings=5)], 1
    yield "where none may come", [welcome(), welcome()], 1
    yield "about stream 0x0", [message(WELCOME, stream=0)], 1
    yield "about another stream", [welcome(), subscribed(1), message(GEOMETRY, stream=1)], 1
    yield "message 7 where 1 is due", [welcome(), message(RESET, text(b""), seq=7)], 1
    yield "a message of type 99", [welcome(), message(99, b"?")], 1
    yield "NEXT from a server", [welcome(), message(13, stream=0)], 1
    yield "where none may come", opening(1)[:-1] + [tile], 1
    yield "where none may come", opening(1) + [message(END, epoch=1)], 1
    yield "STREAM_STATE where none", opening(1) + [tile, message(STATE, b"\1" + text(b""))], 1
    yield "STREAM_STATE of no state", [welcome(), message(STATE, b"\6" + text(b""))], 1
    yield "another length", [welcome(), message(STATE, b"\1\5\0abc")], 1
    yield "control bytes", [welcome(), message(RESET, text(b"a\nb"))], 1
    yield "GEOMETRY 4 + 24", opening(1)[:2] + [geometry(offset=4)], 1
    yield "GEOMETRY 0 + 24 of 28", opening(1)[:2] + [geometry(total=28)], 1
    yield "GEOMETRY 0 + 28", opening(1)[:2] + [geometry(values=[0] * 7)], 1
    yield "GEOMETRY of 8 bytes", opening(1)[:2] + [geometry(values=[])], 1
    yield "COMMIT of 2 tiles after 1", opening(1) + [tile, commit(2)], 1
    yield "COMMIT of epoch 2", opening(1) + [tile, commit(epoch=2)], 1
    yield "COMMIT with clock 4", opening(1) + [tile, commit(clock=4)], 1
    yield "TILE of epoch 2", opening(1) + [message(TILE, CHUNKS[1], epoch=2)], 1
    yield "SNAPSHOT_END of epoch 2", opening(1) + [tile, commit(), message(END, epoch=2)], 1
    yield "COMMIT of epoch 1", opening(1) + [tile, commit(), message(END, epoch=1), commit(0)], 1
    yield "twice in a batch", opening(1) + [tile, tile], 1
    yield "no such scanner (limit, 6)", [message(ERROR, b"\6\0" + text(b"no such scanner"))], 1
    yield "caf\ufffd (limit, 6)", [message(ERROR, b"\6\0" + text(b"caf\xc3"))], 1
    yield "the disk is gone", [welcome(), message(STATE, b"\4" + text(b"the disk is gone"))], 1
    for other in ({"model": 4}, {"wrap": 2}, {"flip": 2}, {"range_bytes": 3}, {"diag": 3}, {"height": 1},
                  {"width": 65536}, {"tile_rows": 2}, {"unit_m": 0.0}, {"unit_m": math.inf}, {"sigma": math.nan}):
        yield "a value that cannot be", [welcome(), subscribed(1, **other)], 1
    for other in ({"mode": 1}, {"normals": 1}, {"stride": 2}, {"bound": 1}, {"range_bytes": 4}):
        yield "not what was asked for", [welcome(), subscribed(1, **other)], 1
    yield "not what was asked for", [welcome(), subscribed(2)], 1
    yield "tables of 20 bytes", [welcome(), subscribed(1, table_bytes=20)], 1
    big = {"height": 65535, "width": 65535, "tile_rows": 1024, "tile_cols": 1024}
    yield "268435456 are the most", [welcome(), subscribed(1, **big)], 1


def lies_of_chunks():
    """(expected words, chunk, encoding)"""
    def put(encoding, at, *values):
        chunk = bytearray(CHUNKS[encoding])
        chunk[at:at + len(values)] = values
        return bytes(chunk)

    yield "which there is none", put(1, 0, 1), 1
    yield "a chunk of encoding 0", put(1, 4, 0), 1
    yield "with sections 0x1", put(1, 5, 1), 1
    yield "7 vertices and 0 triangles", put(1, 8, 0), 1
    yield "4490 vertices", put(1, 6, 0x8A, 0x11), 1
    yield "something in it", b"\0\0\0\0\1" + bytes(6), 1
    yield "TILE of 9 bytes", bytes(9), 1
    yield "counts are not those", put(1, 6, 6), 1
    yield "counts are not those", put(1, 8, 4), 1
    yield "code 7", put(1, 10, 0x77), 1
    yield "", put(1, 11, 0x10), 1  # a bit after the last code
    yield "another length", CHUNKS[1][:-1], 1
    yield "another length", CHUNKS[1] + b"\0", 1
    yield "without a range", put(1, 14, 0, 0), 1
    for skip, code in ((0, 0), (0, 221), (0, 12 + 33), (254, 255), (0, 1)):
        yield "a strut", CHUNKS[1][:12] + bytes((1, 0, skip, code)) + CHUNKS[1][14:], 1
    yield "does not end", CHUNKS[1][:12] + b"\1\0" + b"\xff" * 20, 1
    yield "a strut", CHUNKS[1][:12] + b"\1\0" + b"\xff" * 20 + b"\0\1", 1
    yield "another length", CHUNKS[0] + b"\0", 0
    yield "another length", CHUNKS[0][:-1], 0
    yield "mask", put(0, 10, 1), 0
    yield "mask", put(0, 10, 1)[:18] + b"\x60" + put(0, 10, 1)[19:], 0
    yield "a vertex that is not there", put(0, len(CHUNKS[0]) - 2, 7), 0
    yield "predictor 4", put(2, 14, 4), 2
    yield "bits after the end", put(2, 11, 0x80), 2
    yield "bits after the end", put(2, 22, 0x1C), 2
    yield "residuals of", put(2, 19, 0x1F), 2
    yield "residuals that do not end", put(2, 19, 255, 255, 255, 255), 2
    yield "too short", CHUNKS[2][:-1], 2
    yield "another length", CHUNKS[2] + b"\0", 2
    yield "cell codes that do not end", CHUNKS[2][:10] + b"\xff", 2
    yield "without a range", put(2, 15, 0, 0), 2
    yield "more than 16 bits", put(2, 15, 0, 0, 1), 2


def lies(server):
    cases = list(lies_of_messages())
    for words, chunk, encoding in lies_of_chunks():
        cases.append((words, opening(encoding) + [message(TILE, chunk, epoch=1), commit()], encoding))
    for numpy in KINDS:
        for words, messages, encoding in cases:
            meshes, error = server.meet(said(messages), True, encoding=dexel.ENCODINGS[encoding], numpy=numpy)
            check(isinstance(error, dexel.Error) and not isinstance(error, dexel.ConnectionLost),
                  f"'{words}' (encoding {encoding}): {len(meshes)} meshes, {error!r}")
            check(words in str(error), f"'{words}' (encoding {encoding}): {error!r}")
    # silence where something is due, and where nothing is
    for messages, kind in (([], dexel.ConnectionLost), (opening(1), dexel.ConnectionLost), (opening(1)[:-2], dexel.ConnectionLost),
                           ([welcome()], TimeoutError)):
        _, error = server.meet(said(messages), True, encoding="q16", timeout=0.2)
        check(isinstance(error, kind), f"silence after {len(messages)} messages: {error!r}")
    _, error = server.meet(said(opening(1))[:-5], True, encoding="q16", timeout=0.2)
    check(isinstance(error, dexel.ConnectionLost), f"silence in a message: {error!r}")
    _, error = server.meet(b'{"error":"found a control byte"}\n', False)
    check(isinstance(error, dexel.ProtocolError) and "this seems to be the control socket" in str(error),
          f"a control socket: {error!r}")
    # what a newer server may say besides, a RESET in the middle of a batch, and all anew
    again = opening(1)[1:] + [message(TILE, CHUNKS[1], epoch=1)]
    meshes, error = server.meet(said([welcome(), message(99, b"?", flags=1)] + again + [message(RESET, text(b"short"))] + again
                                     + [commit(), message(END, epoch=1), ENDED]), False, encoding="q16")
    check(error is None and len(meshes) == 1, f"RESET: {error!r}")


def passing(server):
    turns = ([message(ERROR, b"\6\0" + text(b"no room"))], [],
             opening(1) + [message(TILE, CHUNKS[1], epoch=1), commit(), message(END, epoch=1), ENDED])

    def serve():
        for messages in turns:
            peer, _ = server.listening.accept()
            with peer:
                peer.sendall(said(messages))
                peer.shutdown(socket.SHUT_WR)
                while peer.recv(4096):
                    pass

    threading.Thread(target=serve, daemon=True).start()
    told = []
    with dexel.subscribe(server.path, encoding="q16", timeout=300, on_state=lambda *state: told.append(state)) as meshes:
        n = len(list(meshes))
    check(n == 1 and told == [("gone", "no room (limit, 6)"), ("ended", "")], f"{n} meshes, told {told}")


# ------------------------------------------------------------------------------------------ damage


def capture(path, stream, encoding):
    """What the service says until the replay has ended, or for the first million bytes."""
    name = stream.encode()
    hello = struct.pack("<IHHIIQIHHII", 16, 1, 0, NO_STREAM, 0, 0, 0x4C584544, 1, 0, 0, 7)
    wish = struct.pack("<4BI5H", encoding, 2, 3, 0, 0, 0, 0, 0, 0, 0) + text(name)
    heard = b""
    with socket.socket(socket.AF_UNIX) as peer:
        peer.settimeout(300)
        peer.connect(path)
        peer.sendall(hello + struct.pack("<IHHIIQ", len(wish), 4, 0, NO_STREAM, 1, 0) + wish)
        while heard[-3:] != ENDED[6] and len(heard) < 1000000:
            more = peer.recv(65536)
            check(more, "the service closed")
            heard += more
    return heard


def damage(server, path, stream):
    chance = random.Random(11)
    for encoding, name in enumerate(dexel.ENCODINGS):
        whole = capture(path, stream, encoding)
        n_taken = n_refused = 0
        for turn in range(150):
            spoiled = bytearray(whole)
            # mostly among the first messages: there is where the lengths and counts are
            at = chance.randrange(len(whole) if turn % 3 else min(1000, len(whole)))
            if turn % 4:
                spoiled[at] ^= 1 << chance.randrange(8)
            else:
                del spoiled[at:]
            meshes, error = server.meet(bytes(spoiled), False, stream=stream, encoding=name, mode="lossless",
                                        normals=True, numpy=KINDS[turn % len(KINDS)])
            n_refused += error is not None
            n_taken += len(meshes)
            for mesh in meshes:
                mesh.weld()
        check(n_taken > 10 and n_refused > 10, f"{name}: {n_refused} refused, {n_taken} meshes")


def main():
    what, *words = sys.argv[1:]
    if what in ("worked", "lies", "passing", "damage"):
        with tempfile.TemporaryDirectory() as folder:
            globals()[what](Server(folder), *words)
    else:
        globals()[what](*words)


if __name__ == "__main__":
    main()
