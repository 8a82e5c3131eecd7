// A wire between the browser and the server that a test can cut: connections stay open, and nothing
// passes any more.
import { connect, createServer } from 'node:net';

export async function startRelay(port) {
    const pairs = new Set();
    let frozen = false;
    const server = createServer((near) => {
        const far = connect(port, '127.0.0.1');
        const pair = { near, far, streams: false };
        pairs.add(pair);
        near.on('data', (bytes) => {
            pair.streams ||= /^GET \S+\/stream/.test(bytes.toString('latin1'));
            far.write(bytes);
        });
        far.on('data', (bytes) => near.write(bytes));
        const end = () => {
            near.destroy();
            far.destroy();
            pairs.delete(pair);
        };
        for (const one of [near, far]) {
            one.on('error', end);
            one.on('close', end);
        }
        if (frozen) {
            near.pause();
            far.pause();
        }
    });
    await new Promise((ready) => { server.listen(0, '127.0.0.1', ready); });
    const each = (what, which = pairs) => {
        for (const { near, far } of which) {
            near[what]();
            far[what]();
        }
    };
    const streams = () => [...pairs].filter((pair) => pair.streams);
    return {
        port: server.address().port,
        address: `http://127.0.0.1:${server.address().port}/`,
        /** Nothing passes, also in connections that come now. */
        cut() {
            frozen = true;
            each('pause');
        },
        /** Nothing passes in the streams of events that are open; the rest works. */
        cutStreams() {
            each('pause', streams());
        },
        mend() {
            frozen = false;
            each('resume');
        },
        /** How many streams of events are open. */
        streams: () => streams().length,
        close() {
            each('destroy');
            server.close();
        },
    };
}
