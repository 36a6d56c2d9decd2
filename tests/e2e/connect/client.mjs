// A client of the HTTP API with generated code, run by connect_test.py:
//
//     client.mjs GENERATED_FOLDER URL
//
// Prints what it got as one JSON object.
import { Code, ConnectError, createClient } from '@connectrpc/connect';
import { compressionGzip, createConnectTransport } from '@connectrpc/connect-node';

const [folder, baseUrl] = process.argv.slice(2);
const { DatabaseService } = await import(`${folder}/motiondb/v1/database_pb.js`);
const { ClipService } = await import(`${folder}/motiondb/v1/clip_pb.js`);
const { StoreService } = await import(`${folder}/motiondb/v1/store_pb.js`);

// Returns the code and details of the error of a call.
async function errorOf(call) {
  try {
    await call();
  } catch (error) {
    const connect = ConnectError.from(error);
    return {
      code: Code[connect.code],
      message: connect.rawMessage,
      types: connect.details.map((detail) => detail.type),
    };
  }
  return { code: 'none' };
}

async function messagesOf(stream) {
  const messages = [];
  for await (const message of stream) messages.push(message);
  return messages;
}

async function results(useBinaryFormat, options) {
  const transport = createConnectTransport({
    baseUrl,
    httpVersion: '1.1',
    useBinaryFormat,
    ...options,
  });
  const databases = createClient(DatabaseService, transport);
  const clips = createClient(ClipService, transport);
  const store = createClient(StoreService, transport);
  const listed = await databases.listDatabases({}, { timeoutMs: 10_000 });
  const backup = await messagesOf(store.backupStore({}));
  const verified = await messagesOf(store.verifyStore({}));
  return {
    databases: listed.databases.map((database) => database.name),
    backupBytes: backup.reduce((bytes, part) => bytes + part.block.length, 0),
    verified: verified.length,
    notFound: await errorOf(() => databases.getDatabase({ name: 'databases/none' })),
    invalid: await errorOf(() => databases.getDatabase({ name: 'x' })),
    brokenStream: await errorOf(() =>
      messagesOf(clips.exportClip({ name: 'databases/none/clips/none' })),
    ),
    clientStream: await errorOf(() => clips.ingestClip((async function* () {})())),
  };
}

const gzip = { sendCompression: compressionGzip, compressMinBytes: 0 };
console.log(
  JSON.stringify({
    proto: await results(true, {}),
    json: await results(false, {}),
    protoGzip: await results(true, gzip),
    jsonGzip: await results(false, gzip),
  }),
);
