import { useEffect, useState } from 'preact/hooks';
import { errorText, get, post } from '../model/api';
import { absent, api, daemonName, mayChange } from '../model/store';
import { words } from '../model/words';
import { RecordingPlot } from './recording_plot';

const ASK_MS = 500;

interface Recording {
    id: string;
    time: string;
    cause: string;
    bytes: number;
}

interface List {
    directory: string | null;
    recordings: Recording[];
}

interface Writing {
    number: number;
    state: 'writing' | 'written' | 'failed';
    folder?: string;
    reason?: string;
}

const size = (bytes: number): string =>
    bytes < 1e6 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;

const CAUSES: Record<string, string> = {
    failsafe: 'an output went into failsafe', request: 'somebody asked for it',
    crash: 'the process before ended without a word',
};

function RecordNow({ written }: { written: () => void }) {
    const [said, setSaid] = useState('');
    const [busy, setBusy] = useState(false);
    const wait = async (number: number): Promise<string> => {
        for (;;) {
            const now = await get<Writing>(api(`record/${number}`));
            if (now.state === 'written') {
                return `Written to ${now.folder}.`;
            }
            if (now.state === 'failed') {
                return `Not written: ${now.reason}.`;
            }
            await new Promise((done) => setTimeout(done, ASK_MS));
        }
    };
    const record = async () => {
        setBusy(true);
        setSaid('The board writes what it has in memory.');
        try {
            setSaid(await wait((await post<Writing>(api('record'), {})).number));
            written();
        } catch (error) {
            setSaid(errorText(error));
        } finally {
            setBusy(false);
        }
    };
    return (
        <div class="row">
            <button class="main" disabled={busy || !mayChange.value || absent.value}
                onClick={() => void record()}>Record now</button>
            <span role="status">{mayChange.value ? said : 'This browser may only look.'}</span>
        </div>
    );
}

function Item({ one }: { one: Recording }) {
    const [open, setOpen] = useState(false);
    const address = api(`recordings/${encodeURIComponent(one.id)}`);
    const title = open ? 'Close the plot' : 'Plot';
    return (
        <li>
            <h2>{new Date(one.time).toLocaleString()}, {words(one.cause)}</h2>
            <p>{CAUSES[one.cause] ?? words(one.cause)}; {size(one.bytes)}</p>
            <div class="row">
                <button aria-expanded={open} aria-label={`${title} ${one.id}`}
                    onClick={() => setOpen(!open)}>{title}</button>
                <a class="button" href={`${address}.tar`} download
                    aria-label={`Download ${one.id}`}>Download</a>
            </div>
            {open && <RecordingPlot address={address} />}
        </li>
    );
}

function Recordings() {
    const [list, setList] = useState<List | null>(null);
    const [error, setError] = useState('');
    const load = () => {
        get<List>(api('recordings')).then(setList, (failed) => setError(errorText(failed)));
    };
    useEffect(load, []);
    if (error) {
        return <p class="error" role="alert">{error}</p>;
    }
    if (!list) {
        return <p role="status">Waiting for the list.</p>;
    }
    if (list.directory === null) {
        return (
            <p class="empty">There is no recorder. With the table <code>[recorder]</code> in its
                configuration the daemon keeps what passed its ports, and writes it at a
                failsafe.</p>
        );
    }
    return (
        <div class="tool">
            <RecordNow written={load} />
            {list.recordings.length === 0
                && <p class="empty">No recording yet. One is written when an output goes into
                    failsafe.</p>}
            <ul class="list">{list.recordings.map((one) => <Item key={one.id} one={one} />)}</ul>
            <p class="quiet">On the board: <code>{list.directory}</code></p>
        </div>
    );
}

export function RecordingsScreen() {
    return <Recordings key={daemonName.value} />;
}
