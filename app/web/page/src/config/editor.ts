// CodeMirror in a shadow root, where the content security policy lets it have its styles.
import { autocompletion, completionKeymap } from '@codemirror/autocomplete';
import { defaultKeymap, history, historyKeymap } from '@codemirror/commands';
import { HighlightStyle, StreamLanguage, syntaxHighlighting } from '@codemirror/language';
import { toml } from '@codemirror/legacy-modes/mode/toml';
import { lintGutter, setDiagnostics, type Diagnostic } from '@codemirror/lint';
import { EditorState } from '@codemirror/state';
import {
    drawSelection, EditorView, highlightActiveLine, keymap, lineNumbers,
} from '@codemirror/view';
import { tags } from '@lezer/highlight';
import type { Mistake } from '../model/status';
import { complete, type Schema } from './completion';

const colours = HighlightStyle.define([
    { tag: tags.comment, color: 'var(--quiet)', fontStyle: 'italic' },
    { tag: tags.string, color: 'var(--control)' },
    { tag: [tags.number, tags.bool, tags.atom], color: 'var(--hold)' },
    { tag: [tags.propertyName, tags.variableName], color: 'var(--text)' },
    { tag: [tags.keyword, tags.bracket], color: 'var(--link)' },
]);

const look = EditorView.theme({
    '&': { color: 'var(--text)', backgroundColor: 'var(--back)', fontSize: '0.9375rem' },
    '&.cm-focused': { outline: '3px solid var(--link)' },
    '.cm-scroller': {
        fontFamily: 'ui-monospace, "DejaVu Sans Mono", monospace', minHeight: '16rem',
    },
    '.cm-content': { caretColor: 'var(--text)' },
    '.cm-cursor': { borderLeftColor: 'var(--text)', borderLeftWidth: '2px' },
    '.cm-gutters': {
        backgroundColor: 'var(--raised)', color: 'var(--quiet)',
        borderRight: '1px solid var(--line)',
    },
    '.cm-activeLine, .cm-activeLineGutter': { backgroundColor: 'transparent' },
    '&.cm-focused .cm-activeLine': { boxShadow: 'inset 3px 0 var(--link)' },
    ['&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, '
        + '.cm-selectionBackground']: { backgroundColor: 'var(--line)' },
    '.cm-tooltip': {
        backgroundColor: 'var(--raised)', color: 'var(--text)', border: '1px solid var(--edge)',
        maxWidth: '24rem',
    },
    '.cm-tooltip-autocomplete > ul > li': { padding: '6px 8px', lineHeight: '1.3' },
    '.cm-tooltip-autocomplete > ul > li[aria-selected]': {
        backgroundColor: 'var(--link)', color: 'var(--back)',
    },
    '.cm-lintRange-error': {
        backgroundImage: 'none', borderBottom: '3px double var(--failsafe)',
    },
    '.cm-diagnostic-error': { borderLeftColor: 'var(--failsafe)' },
});

export interface EditorOptions {
    text: string;
    readOnly: boolean;
    schema: () => Schema | null;
    changed: (text: string) => void;
}

export class Editor {
    private readonly view: EditorView;

    constructor(host: HTMLElement, options: EditorOptions) {
        const root = host.shadowRoot ?? host.attachShadow({ mode: 'open' });
        this.view = new EditorView({ root, parent: root, state: stateOf(options) });
    }

    /** A text from elsewhere: the file of another, a merged one. */
    setText(text: string): void {
        const { doc } = this.view.state;
        if (doc.toString() !== text) {
            this.view.dispatch({ changes: { from: 0, to: doc.length, insert: text } });
        }
    }

    mark(mistakes: Mistake[]): void {
        const { state } = this.view;
        const found = mistakes.map((one) => diagnostic(state, one));
        this.view.dispatch(setDiagnostics(state, found));
    }

    goTo(mistake: Mistake): void {
        const { from } = diagnostic(this.view.state, mistake);
        this.view.dispatch({ selection: { anchor: from }, scrollIntoView: true });
        this.view.focus();
    }

    close(): void {
        this.view.destroy();
    }
}

/** From the place of a mistake to the end of its word; the text may be shorter by now. */
function diagnostic(state: EditorState, mistake: Mistake): Diagnostic {
    const line = state.doc.line(Math.min(Math.max(1, mistake.line), state.doc.lines));
    const from = Math.min(line.from + Math.max(0, mistake.column - 1), line.to);
    const word = /^["\w.-]+/.exec(line.text.slice(from - line.from))?.[0].length ?? 1;
    return { from, to: Math.min(from + word, line.to), severity: 'error', message: mistake.text };
}

function stateOf(options: EditorOptions): EditorState {
    return EditorState.create({
        doc: options.text,
        extensions: [
            lineNumbers(), lintGutter(), history(), drawSelection(), highlightActiveLine(),
            StreamLanguage.define(toml), syntaxHighlighting(colours), look,
            autocompletion({
                override: [(context) => {
                    const schema = options.schema();
                    return schema ? complete(schema, context) : null;
                }],
            }),
            // Tab leaves the editor: who has only a keyboard must get out.
            keymap.of([...completionKeymap, ...defaultKeymap, ...historyKeymap]),
            EditorState.readOnly.of(options.readOnly),
            EditorView.contentAttributes.of({ 'aria-label': 'Configuration' }),
            EditorView.lineWrapping,
            EditorView.updateListener.of((update) => {
                if (update.docChanged) {
                    options.changed(update.state.doc.toString());
                }
            }),
        ],
    });
}
