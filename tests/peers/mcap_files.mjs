// A binary PCD of x y z intensity and a binary PLY mesh in the words in which mcap_peer.mjs tells the cloud and the
// scene that `dexel convert --ros both` makes of the same scan.
//   node mcap_files.mjs CLOUD.pcd MESH.ply
import { readFileSync } from "node:fs";

const [pcd, ply] = process.argv.slice(2).map((path) => readFileSync(path));
const lines = [];

// The header's lines up to the one that ends it, and the bytes behind it.
function split(file, last) {
  const end = file.indexOf(last) + last.length;
  const body = file.subarray(end);
  return [file.subarray(0, end).toString(), new DataView(body.buffer, body.byteOffset, body.byteLength)];
}
const number = (header, word) => Number(new RegExp(`${word} (\\d+)`).exec(header)[1]);

const [head, points] = split(pcd, "DATA binary\n");
const [width, height] = [number(head, "WIDTH"), number(head, "HEIGHT")];
lines.push(`scanner 0.0 ${height}x${width} step 16 ${16 * width} big false dense false`);
lines.push("x:0:7:1 y:4:7:1 z:8:7:1 intensity:12:7:1");
for (let at = 0; at < 16 * width * height; at += 16)
  lines.push([0, 4, 8, 12].map((i) => points.getFloat32(at + i, true)).join(" "));

const [plyHead, mesh] = split(ply, "end_header\n");
const properties = plyHead.slice(plyHead.indexOf("element vertex"), plyHead.indexOf("element face"));
const lengths = { float: 4, uchar: 1, ushort: 2 };
const step = [...properties.matchAll(/property (\w+) \w+/g)].reduce((sum, m) => sum + lengths[m[1]], 0);
const nVertices = number(plyHead, "element vertex"), nFaces = number(plyHead, "element face");
lines.push("delete 0.0 1 ''");
lines.push("entity 0.0 scanner mesh/0 for 0.0 locked false others 00000000", "at 0 0 0, 0 0 0 1");
const indices = [], order = [], seen = new Map();
for (let f = 0, at = step * nVertices; f < nFaces; f++, at += 13)
  for (let k = 0; k < 3; k++) {
    const v = mesh.getUint32(at + 1 + 4 * k, true);
    if (!seen.has(v)) {
      seen.set(v, order.length);
      order.push(v);
    }
    indices.push(seen.get(v));
  }
for (const v of order) lines.push([0, 4, 8].map((i) => mesh.getFloat32(step * v + i, true)).join(" "));
lines.push("color 0.75 0.75 0.75 1", `indices ${indices.join(" ")}`);
process.stdout.write(lines.join("\n") + "\n");
