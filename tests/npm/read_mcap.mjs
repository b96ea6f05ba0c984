// Reads an MCAP file with its index and prints what is in it as JSON: whoever reads it so needs every offset to be right.
// Usage: node read_mcap.mjs FILE
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";

const { McapIndexedReader, McapStreamReader } = createRequire(join(process.env.SINEW_NODE_MODULES, "here.js"))("@mcap/core");

const file = await readFile(process.argv[2]);
const readable = {
  size: async () => BigInt(file.byteLength),
  read: async (offset, length) => new Uint8Array(file.buffer, file.byteOffset + Number(offset), Number(length)),
};
const reader = await McapIndexedReader.Initialize({ readable });
const topic = (id) => reader.channelsById.get(id).topic;
const messages = [];
for await (const message of reader.readMessages()) {
  messages.push({
    topic: topic(message.channelId),
    sequence: message.sequence,
    log_time_ns: message.logTime.toString(),
    data: JSON.parse(new TextDecoder("utf8", { fatal: true }).decode(message.data)),
  });
}
const attachments = [];
for await (const attachment of reader.readAttachments()) {
  attachments.push({ name: attachment.name, media_type: attachment.mediaType, text: new TextDecoder().decode(attachment.data) });
}
const metadata = [];
for await (const one of reader.readMetadata()) {
  metadata.push({ name: one.name, values: Object.fromEntries(one.metadata) });
}

// The same from front to back, with every checksum.
const stream = new McapStreamReader({ validateCrcs: true });
stream.append(new Uint8Array(file.buffer, file.byteOffset, file.byteLength));
let streamed = 0;
for (let record; (record = stream.nextRecord()); ) {
  streamed += record.type === "Message";
}

console.log(JSON.stringify({
  library: reader.header.library,
  done: stream.done(),
  streamed,
  messages,
  attachments,
  metadata,
  statistics: {
    messages: Number(reader.statistics.messageCount),
    channels: reader.statistics.channelCount,
    chunks: reader.statistics.chunkCount,
    by_topic: Object.fromEntries([...reader.statistics.channelMessageCounts].map(([id, count]) => [topic(id), Number(count)])),
  },
  schemas: Object.fromEntries([...reader.schemasById.values()].map((schema) =>
    [schema.name, { encoding: schema.encoding, schema: JSON.parse(new TextDecoder().decode(schema.data)) }])),
  channels: Object.fromEntries([...reader.channelsById.values()].map((channel) =>
    [channel.topic, { encoding: channel.messageEncoding, schema: reader.schemasById.get(channel.schemaId)?.name,
                      metadata: Object.fromEntries(channel.metadata) }])),
}));
