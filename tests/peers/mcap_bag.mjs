// A binary PCD of x y z intensity as the MCAP file of another program, by @mcap/core and
// @foxglove/rosmsg2-serialization: PointCloud2 messages on two topics, beside one of another type. On /packed they lie as
// in the PCD; on /padded as PCL lays them out, 32 bytes a point and rows with bytes behind them.
//   node mcap_bag.mjs CLOUD.pcd OUT.mcap
import { readFileSync, writeFileSync } from "node:fs";
import { McapWriter } from "@mcap/core";
import { parse, stringify } from "@foxglove/rosmsg";
import { ros2humble } from "@foxglove/rosmsg-msgs-common";
import { MessageWriter } from "@foxglove/rosmsg2-serialization";

const [from, to] = process.argv.slice(2);
const pcd = readFileSync(from);
const end = pcd.indexOf("DATA binary\n") + "DATA binary\n".length;
const number = (word) => Number(new RegExp(`${word} (\\d+)`).exec(pcd.subarray(0, end).toString())[1]);
const [width, height] = [number("WIDTH"), number("HEIGHT")];

function cloud(offsets, pointStep, rowStep, stamp) {
  const data = new Uint8Array(rowStep * height).fill(0xee);
  for (let row = 0; row < height; row++)
    for (let col = 0; col < width; col++)
      offsets.forEach((offset, k) => {
        const at = end + 16 * (row * width + col) + 4 * k;
        data.set(pcd.subarray(at, at + 4), row * rowStep + col * pointStep + offset);
      });
  const fields = ["x", "y", "z", "intensity"].map((name, k) => ({ name, offset: offsets[k], datatype: 7, count: 1 }));
  return { header: { stamp, frame_id: "laser" }, height, width, fields, is_bigendian: false,
    point_step: pointStep, row_step: rowStep, data, is_dense: false };
}

// A type and all that it uses, as the text of a Schema record.
function schemaText(name) {
  const all = [], seen = new Set();
  const add = (n) => {
    if (seen.has(n)) return;
    seen.add(n);
    all.push({ ...ros2humble[n], name: n === name ? undefined : n });
    for (const f of ros2humble[n].definitions) if (f.isComplex) add(f.type);
  };
  add(name);
  return stringify(all);
}

const parts = [];
let position = 0n;
const writer = new McapWriter({ writable: {
  write: async (b) => { parts.push(Buffer.from(b)); position += BigInt(b.length); },
  position: () => position,
} });
await writer.start({ profile: "ros2", library: "a peer" });

async function channel(topic, type, dotted) {
  const text = schemaText(type);
  const schemaId = await writer.registerSchema({ name: dotted, encoding: "ros2msg", data: Buffer.from(text) });
  const id = await writer.registerChannel({ topic, schemaId, messageEncoding: "cdr",
    metadata: new Map([["offered_qos_profiles", ""]]) });
  const encoder = new MessageWriter(parse(text, { ros2: true }));
  return async (time, m) => writer.addMessage({ channelId: id, sequence: 0, logTime: time, publishTime: time,
    data: encoder.writeMessage(m) });
}
const text = await channel("/text", "std_msgs/String", "std_msgs/msg/String");
const packed = await channel("/packed", "sensor_msgs/PointCloud2", "sensor_msgs/msg/PointCloud2");
const padded = await channel("/padded", "sensor_msgs/PointCloud2", "sensor_msgs/msg/PointCloud2");
for (let k = 0; k < 3; k++) {
  const time = 1700000000000000000n + BigInt(k) * 100000000n, stamp = { sec: 1700000000, nanosec: k * 100000000 };
  await text(time, { data: "nothing to see" });
  await packed(time + 1n, cloud([0, 4, 8, 12], 16, 16 * width, stamp));
  await padded(time + 2n, cloud([0, 4, 8, 16], 32, 32 * width + 8, stamp));
}
await writer.end();
writeFileSync(to, Buffer.concat(parts));
