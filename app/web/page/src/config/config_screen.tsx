import { useComputed } from '@preact/signals';
import { useEffect, useRef, useState } from 'preact/hooks';
import { errorText, get, post, statusOf } from '../model/api';
import {
    changed, draft, fileOnDisk, openDraft, setDraft, setText, type Draft,
} from '../model/draft';
import type { Mistake } from '../model/status';
import { absent, api, daemon, daemonName, mayChange, newest } from '../model/store';
import { runningTrial, TRIAL_S, tryDraft } from '../model/trial';
import { checkSoon, stopChecking, verdict } from './checking';
import type { Schema } from './completion';
import type { Editor } from './editor';
import { HistoryView } from './history_view';
import { MergeView } from './merge_view';
import { VerdictView } from './verdict_view';

interface EditorProps {
    hold: (editor: Editor | null) => void;
}

/** The editor follows the draft, and the draft the editor. */
function EditorView({ hold }: EditorProps) {
    const host = useRef<HTMLDivElement>(null);
    const [error, setError] = useState('');
    useEffect(() => {
        let editor: Editor | null = null;
        let wanted = true;
        let schema: Schema | null = null;
        get<Schema>(api('schema')).then((answer) => { schema = answer; }, () => {
            // Without a schema nothing is completed; the check works all the same.
        });
        import('./editor').then((part) => {
            if (wanted && host.current) {
                editor = new part.Editor(host.current, {
                    text: draft.peek()?.text ?? '', readOnly: !mayChange.peek(),
                    schema: () => schema, changed: setText,
                });
                hold(editor);
            }
        }, () => setError('The editor did not arrive. Load the page again.'));
        return () => {
            wanted = false;
            editor?.close();
            hold(null);
        };
    }, []);
    return (
        <div>
            <div class="editor" ref={host} />
            {error && <p class="error" role="alert">{error}</p>}
        </div>
    );
}

interface ActionsProps {
    changedByAnother: (theirs: Draft) => void;
}

/** Try, or write if there is no daemon that could try it. */
function Actions({ changedByAnother }: ActionsProps) {
    const [said, setSaid] = useState<string[]>([]);
    const [busy, setBusy] = useState(false);
    const now = draft.value;
    const judged = verdict.value;
    const ready = !busy && now !== undefined && judged !== null && judged.text === now.text
        && judged.mistakes.length === 0 && !judged.error && runningTrial.value === null;
    const run = async (what: (now: Draft) => Promise<string[]>) => {
        setBusy(true);
        setSaid([]);
        try {
            setSaid(now ? await what(now) : []);
        } catch (error) {
            setSaid([errorText(error)]);
        } finally {
            setBusy(false);
        }
    };
    const merge = async () => {
        changedByAnother(await fileOnDisk(daemonName.value));
        return [];
    };
    const attempt = () => run(async (text) => {
        const tried = await tryDraft(text);
        return tried.kind === 'changed' ? merge()
            : tried.kind === 'refused' ? ['Refused; what ran before goes on.', ...tried.lines] : [];
    });
    const write = () => run(async (text) => {
        try {
            const { fingerprint } = await post<{ fingerprint: string }>(api('save'),
                { toml: text.text }, { match: text.tag });
            const tag = `"${fingerprint}"`;
            setDraft(daemonName.value, { base: text.text, tag, text: text.text });
            return ['Written to the file.'];
        } catch (error) {
            return statusOf(error) === 412 ? merge() : Promise.reject(error);
        }
    });
    const drop = () => now && setDraft(daemonName.value, { ...now, text: now.base });
    return (
        <section class="actions" aria-label="Actions">
            <div class="row">
                {absent.value
                    ? <button class="main" disabled={!ready || !changed.value}
                        onClick={() => void write()}>Write to the file</button>
                    : <button class="main" disabled={!ready || (judged.same && !changed.value)}
                        onClick={() => void attempt()}>Try for {TRIAL_S} s</button>}
                <button disabled={!changed.value} onClick={drop}>Drop my changes</button>
            </div>
            <p class="quiet">{absent.value
                ? 'No daemon runs: the text is written, and runs when the daemon starts.'
                : `On trial for ${TRIAL_S} s; goes back by itself unless you keep it.`}</p>
            <div role="alert">{said.map((line) => <p key={line}>{line}</p>)}</div>
        </section>
    );
}

function Editing() {
    const editor = useRef<Editor | null>(null);
    const [theirs, setTheirs] = useState<Draft | null>(null);
    const text = useComputed(() => draft.value?.text ?? '');
    useEffect(() => text.subscribe((now) => {
        editor.current?.setText(now);
        checkSoon(now);
    }), []);
    useEffect(() => verdict.subscribe((now) => {
        // While a text waits for its check, the marks of the one before move with it.
        if (now) {
            editor.current?.mark(now.mistakes);
        }
    }), []);
    useEffect(() => stopChecking, []);
    const use = (merged: string) => {
        if (theirs) {
            setDraft(daemonName.value, { ...theirs, text: merged });
            setTheirs(null);
        }
    };
    const mine = draft.value;
    return (
        <div class="config">
            {theirs && mine
                && <MergeView mine={mine} theirs={theirs} use={use}
                    leave={() => setTheirs(null)} />}
            {!mayChange.value && (
                <p class="hint">This browser may only look. To change the configuration, pair it
                    again without <code>--look</code>.</p>
            )}
            <EditorView hold={(made) => {
                editor.current = made;
                made?.mark(verdict.peek()?.mistakes ?? []);
            }} />
            <div class="beside">
                {mayChange.value && <Actions changedByAnother={setTheirs} />}
                <VerdictView goTo={(mistake: Mistake) => editor.current?.goTo(mistake)} />
                {mayChange.value && <HistoryView use={setText} />}
            </div>
        </div>
    );
}

/**
 * One editor for each daemon. The file is read when the screen opens, and when the daemon runs
 * another text: somebody may have reloaded it, and what was said of the draft is then old.
 */
function Opened({ name }: { name: string }) {
    const [error, setError] = useState('');
    const running = useComputed(() => newest.value?.fingerprint ?? '');
    useEffect(() => running.subscribe(() => {
        openDraft(name).then(
            () => checkSoon(draft.peek()?.text ?? ''), (failed) => setError(errorText(failed)));
    }), []);
    return (
        <>
            <p class="quiet">{daemon.value?.file}{absent.value && ', no daemon runs'}</p>
            {error && <p class="error" role="alert">{error}</p>}
            {draft.value && <Editing key={String(mayChange.value)} />}
        </>
    );
}

export function ConfigScreen() {
    return <Opened key={daemonName.value} name={daemonName.value} />;
}
