"""What dexel.py makes of recorded connections (tests/protocol): recorded.py OUT SAID.client ... writes OUT/SAID.meshes,
with the lines of recorded.c but for streams, resets and what comes after the end."""
import os
import socket
import struct
import sys
import tempfile
import threading
import zlib

import dexel


def flat(code, rows):
    values = [value for row in rows for value in row]
    return struct.pack(f"<{len(values)}{code}", *values)


def tile_bytes(tile, stream):
    n = len(tile.vertices)
    data = struct.pack("<4I", tile.row, tile.col, n, len(tile.triangles))
    data += flat("f", tile.vertices) + flat("H", tile.triangles)
    data += struct.pack(f"<{n}I", *tile.names)
    if stream.attr_bytes:
        data += struct.pack(f"<{n}H", *tile.attributes)
    if stream.normals:
        data += flat("f", tile.normals)
    return data


def tell(out, mesh):
    crc = 0
    for key in sorted(mesh.tiles):
        crc = zlib.crc32(tile_bytes(mesh.tiles[key], mesh.stream), crc)
    print(f"commit {mesh.epoch}, frame {mesh.frame}, caps {mesh.caps[0]:d} {mesh.caps[1]:d}: {len(mesh.tiles)} tiles, "
          f"{mesh.n_triangles} triangles, {crc:08x}", file=out)


def serve(listening, heard):
    peer, _ = listening.accept()
    with peer:
        try:
            peer.sendall(heard)
            peer.shutdown(socket.SHUT_WR)
            while peer.recv(4096):
                pass
        except OSError:
            pass  # it had enough


def follow(out, said, heard):
    # SUBSCRIBE is the second message
    at = 24 + struct.unpack_from("<I", said)[0] + 24
    encoding, mode, want, stride, interval, *region, bound = struct.unpack_from("<4BI5H", said, at)
    name = said[at + 20:at + 20 + struct.unpack_from("<H", said, at + 18)[0]].decode()
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "s")
        with socket.socket(socket.AF_UNIX) as listening:
            listening.bind(path)
            listening.listen(1)
            thread = threading.Thread(target=serve, args=(listening, heard))
            thread.start()
            try:
                with dexel.subscribe(path, name, encoding=dexel.ENCODINGS[encoding], mode=dexel.MODES[mode],
                                     attributes=bool(want & 1), normals=bool(want & 2), stride=stride,
                                     bound=bound / 16, region=tuple(region) if any(region) else None,
                                     reconnect=False, timeout=300) as meshes:
                    for mesh in meshes:
                        tell(out, mesh)
                print("ended", file=out)
            except dexel.ServerError as error:
                print(f"error {error.code}", file=out)
            thread.join()


def read(path):
    with open(path, "rb") as file:
        return file.read()


def main():
    for path in sys.argv[2:]:
        name = os.path.basename(path)[:-len(".client")]
        with open(os.path.join(sys.argv[1], name + ".meshes"), "w", encoding="ascii") as out:
            follow(out, read(path), read(path[:-len(".client")] + ".server"))


main()
