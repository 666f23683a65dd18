// The other side of tests/peers/mcap.sh, through @mcap/core and @mcap/support: writes recordings in every
// way that library can (it cannot compress with lz4: lz4js does), or lists one in the same words as mcap_peer.c does.
//   node mcap_peer.mjs write FILE none|lz4|zstd [noindex] [nochunks] [nosummary] [norepeat] [unknown]
//   node mcap_peer.mjs list|stream FILE
//   node mcap_peer.mjs ros FILE         each PointCloud2 and SceneUpdate, decoded by the schema in the file
//   node mcap_peer.mjs schema FILE      the types of each schema, beside those that @foxglove/schemas publishes
import { readFileSync, writeFileSync } from "node:fs";
import { McapIndexedReader, McapStreamReader, McapWriter } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { crc32 } from "@foxglove/crc";
import foxgloveSchemas from "@foxglove/schemas/internal.js";
import lz4 from "lz4js";
import * as zstdModule from "@foxglove/wasm-zstd";

const zstd = zstdModule.default ?? zstdModule;
const [mode, path, ...words] = process.argv.slice(2);
const hex = (bytes) => crc32(bytes).toString(16).padStart(8, "0");
const lines = [];

// ---- list -------------------------------------------------------------------------------------------

function channelLine(c, schema) {
  const words = ["C", c.id, c.topic, c.messageEncoding];
  if (schema) words.push(schema.name, schema.encoding, hex(schema.data));
  for (const [k, v] of c.metadata) words.push(`${k}=${v}`);
  return words.join(" ");
}
const messageLine = (m, topic) =>
  ["M", topic, m.sequence, m.logTime, m.publishTime, m.data.byteLength, hex(m.data)].join(" ");
const attachmentLine = (a) =>
  ["A", a.name, a.mediaType, a.logTime, a.createTime, a.data.byteLength, hex(a.data)].join(" ");
const metadataLine = (m) => ["D", m.name, ...[...m.metadata].map(([k, v]) => `${k}=${v}`)].join(" ");

// The CRC of the data section, which the library itself does not check.
function checkDataCrc(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  for (let at = 8; at < bytes.length - 8; at += 9 + Number(view.getBigUint64(at + 1, true))) {
    if (bytes[at] !== 0x0f) continue;
    const crc = view.getUint32(at + 9, true);
    if (crc !== 0 && crc !== crc32(bytes.subarray(0, at))) throw new Error("data section: wrong CRC");
    return;
  }
  throw new Error("no DataEnd");
}

async function list(bytes, decompressHandlers) {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.slice(Number(offset), Number(offset + length)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  for await (const m of reader.readMessages({ validateCrcs: true }))
    lines.push(messageLine(m, reader.channelsById.get(m.channelId).topic));
  for (const c of reader.channelsById.values()) lines.push(channelLine(c, reader.schemasById.get(c.schemaId)));
  for await (const a of reader.readAttachments({ validateCrcs: true })) lines.push(attachmentLine(a));
  for await (const m of reader.readMetadata()) lines.push(metadataLine(m));
  if (Number(reader.statistics.messageCount) !== lines.filter((l) => l[0] === "M").length)
    throw new Error(`statistics: ${reader.statistics.messageCount} messages`);
}

function stream(bytes, decompressHandlers) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const channels = new Map(), schemas = new Map(), attachments = [], metadata = [];
  reader.append(bytes);
  for (let r; (r = reader.nextRecord()); ) {
    if (r.type === "Schema") schemas.set(r.id, r);
    else if (r.type === "Channel") channels.set(r.id, r);
    else if (r.type === "Message") lines.push(messageLine(r, channels.get(r.channelId).topic));
    else if (r.type === "Attachment") attachments.push(attachmentLine(r));
    else if (r.type === "Metadata") metadata.push(metadataLine(r));
  }
  if (!reader.done()) throw new Error("the stream did not end");
  for (const c of channels.values()) lines.push(channelLine(c, schemas.get(c.schemaId)));
  lines.push(...attachments, ...metadata);
}

// ---- messages of ROS --------------------------------------------------------------------------------

const time = (t) => `${t.sec}.${t.nanosec ?? t.nsec}`;
const xyz = (p) => `${p.x} ${p.y} ${p.z}`;
const rgba = (c) => `${c.r} ${c.g} ${c.b} ${c.a}`;

function cloudLines(m) {
  const view = new DataView(m.data.buffer, m.data.byteOffset, m.data.byteLength);
  lines.push(`${m.header.frame_id} ${time(m.header.stamp)} ${m.height}x${m.width} ` +
    `step ${m.point_step} ${m.row_step} big ${m.is_bigendian} dense ${m.is_dense}`);
  lines.push(m.fields.map((f) => `${f.name}:${f.offset}:${f.datatype}:${f.count}`).join(" "));
  const get = (f, at) => (f.datatype === 4 ? view.getUint16(at + f.offset, true) : view.getFloat32(at + f.offset, true));
  for (let at = 0; at < m.data.length; at += m.point_step) lines.push(m.fields.map((f) => get(f, at)).join(" "));
}

function sceneLines(m) {
  for (const d of m.deletions) lines.push(`delete ${time(d.timestamp)} ${d.type} '${d.id}'`);
  for (const e of m.entities) {
    const none = ["metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "texts", "models"];
    lines.push(`entity ${time(e.timestamp)} ${e.frame_id} ${e.id} for ${time(e.lifetime)} locked ${e.frame_locked} ` +
      `others ${none.map((n) => e[n].length).join("")}`);
    for (const t of e.triangles) {
      lines.push(`at ${xyz(t.pose.position)}, ${xyz(t.pose.orientation)} ${t.pose.orientation.w}`);
      for (const p of t.points) lines.push(xyz(p));
      lines.push(`color ${rgba(t.color)}`);
      for (const c of t.colors) lines.push(rgba(c));
      lines.push(`indices ${[...t.indices].join(" ")}`);
    }
  }
}

function messages(bytes, decompressHandlers) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const schemas = new Map(), channels = new Map();
  reader.append(bytes);
  for (let r; (r = reader.nextRecord()); ) {
    if (r.type === "Schema") schemas.set(r.id, r);
    else if (r.type === "Channel") channels.set(r.id, r);
    if (r.type !== "Message") continue;
    const schema = schemas.get(channels.get(r.channelId).schemaId);
    const decoder = new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true }));
    const m = decoder.readMessage(r.data);
    if (schema.name === "sensor_msgs/msg/PointCloud2") cloudLines(m);
    else sceneLines(m);
  }
  if (!reader.done()) throw new Error("the file did not end");
}

// Fields in their order, constants apart: they are in no message. Of builtin_interfaces the parser makes its own.
function types(text) {
  const fields = (d, constant) =>
    d.definitions.filter((f) => !!f.isConstant === constant)
      .map((f) => `${f.type}${f.isArray ? "[]" : ""} ${f.name}${constant ? `=${f.value}` : ""}`);
  return parse(text, { ros2: true })
    .filter((d) => !(d.name ?? "").startsWith("builtin_interfaces/"))
    .map((d) => `${d.name ?? "the message"}: ${fields(d, false).join(", ")}; ${fields(d, true).join(", ")}`)
    .sort();
}

function schemaTypes(bytes, decompressHandlers) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const { foxgloveMessageSchemas, generateRosMsgMergedSchema } = foxgloveSchemas;
  reader.append(bytes);
  for (let r; (r = reader.nextRecord()); ) {
    const published = r.type === "Schema" && foxgloveMessageSchemas[r.name.replace("foxglove_msgs/msg/", "")];
    if (!published) continue;
    const ours = types(new TextDecoder().decode(r.data));
    const theirs = types(generateRosMsgMergedSchema(published, { rosVersion: 2 }));
    if (ours.join("\n") !== theirs.join("\n"))
      throw new Error(`${r.name}:\n${ours.join("\n")}\nis published as\n${theirs.join("\n")}`);
    lines.push(`${r.name} ${ours.length} types`);
  }
}

// ---- write ------------------------------------------------------------------------------------------

function compressor(name) {
  if (name === "none") return undefined;
  return (data) => ({
    compression: name,
    compressedData: new Uint8Array(name === "lz4" ? lz4.compress(data) : zstd.compress(data, 3)),
  });
}

const join = (parts) => new Uint8Array(Buffer.concat(parts));

function record(op, body) {
  const head = new Uint8Array(9);
  head[0] = op;
  new DataView(head.buffer).setBigUint64(1, BigInt(body.length), true);
  return join([head, body]);
}

// Records of kinds that nobody knows, between all others and at the end of each plain chunk; the file has
// then no summary.
function addUnknown(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const unknown = [record(0x91, Buffer.from("private")), record(0x42, Buffer.from("of a later version"))];
  const parts = [bytes.subarray(0, 8)];
  for (let at = 8; bytes[at] !== 0x0f; ) {
    const end = at + 9 + Number(view.getBigUint64(at + 1, true));
    let r = bytes.subarray(at, end);
    if (r[0] === 0x06 && view.getUint32(at + 9 + 28, true) === 0) {
      const records = join([r.subarray(9 + 40), ...unknown]);
      const head = r.slice(9, 9 + 40);
      const h = new DataView(head.buffer);
      h.setBigUint64(16, BigInt(records.length), true);
      h.setUint32(24, crc32(records), true);
      h.setBigUint64(32, BigInt(records.length), true);
      r = record(0x06, join([head, records]));
    }
    parts.push(r, ...unknown);
    at = end;
  }
  const crc = new Uint8Array(4);
  new DataView(crc.buffer).setUint32(0, crc32(join(parts)), true);
  parts.push(record(0x0f, crc), record(0x02, new Uint8Array(20)), bytes.subarray(0, 8));
  return join(parts);
}

async function write() {
  const parts = [];
  let position = 0n;
  const has = (word) => words.includes(word);
  const writable = {
    write: async (b) => { parts.push(new Uint8Array(b)); position += BigInt(b.length); },
    position: () => position,
  };
  const writer = new McapWriter({
    writable,
    chunkSize: 50000,
    compressChunk: compressor(words[0]),
    useChunks: !has("nochunks"),
    useChunkIndex: !has("noindex"),
    useMessageIndex: !has("noindex"),
    useStatistics: !has("nosummary"),
    useSummaryOffsets: !has("nosummary"),
    repeatChannels: !has("nosummary") && !has("norepeat"),
    repeatSchemas: !has("nosummary") && !has("norepeat"),
    useAttachmentIndex: !has("nosummary"),
    useMetadataIndex: !has("nosummary"),
  });
  await writer.start({ profile: "", library: "a peer" });
  const schemaId = await writer.registerSchema({ name: "T", encoding: "jsonschema", data: Buffer.from("{}") });
  const ids = [];
  for (let k = 0; k < 4; k++)
    ids.push(await writer.registerChannel({ topic: `/t${k}`, schemaId: k % 2 ? schemaId : 0,
      messageEncoding: "json", metadata: new Map(k ? [] : [["a", "b"]]) }));
  await writer.addMetadata({ name: "meta", metadata: new Map([["x", "1"], ["y", "zwei"]]) });
  for (let k = 0; k < 3000; k++) {
    const data = new Uint8Array((k * 7919) % 2000).map((_, i) => (i % 7 ? i >> 4 : (i * k) >> 3));
    const logTime = BigInt(5000000000 + (k + 100 - (k % 4) * 30) * 1000 + (k % 4));
    await writer.addMessage({ channelId: ids[k % 4], sequence: k, logTime, publishTime: logTime + 1n, data });
    if (k === 1500)
      await writer.addAttachment({ name: "note", mediaType: "text/plain", logTime: 3n, createTime: 4n,
        data: Buffer.from("some words") });
  }
  await writer.end();
  writeFileSync(path, has("unknown") ? addUnknown(join(parts)) : join(parts));
}

const handlers = await loadDecompressHandlers();
await zstd.isLoaded;
if (mode === "write") {
  await write();
} else {
  const bytes = new Uint8Array(readFileSync(path));
  checkDataCrc(bytes);
  if (mode === "list") await list(bytes, handlers);
  else if (mode === "ros") messages(bytes, handlers);
  else if (mode === "schema") schemaTypes(bytes, handlers);
  else stream(bytes, handlers);
  process.stdout.write(lines.join("\n") + "\n");
}
