// The file was changed by another: theirs beside mine.
import { useState } from 'preact/hooks';
import type { Draft } from '../model/draft';
import { merge, type Piece } from './line_merge';

type Choice = 'mine' | 'theirs' | 'both';
const CHOICES: [Choice, string][] = [
    ['mine', 'Mine'], ['theirs', 'Theirs'], ['both', 'Both, theirs first'],
];

const TITLES = { mine: 'Changed by you', theirs: 'Changed by another' } as const;

function chosen(piece: Piece, choice: Choice | undefined): string[] {
    if (piece.kind !== 'conflict') {
        return piece.lines;
    }
    return choice === 'both' ? [...piece.theirs, ...piece.mine]
        : choice === 'theirs' ? piece.theirs : piece.mine;
}

interface ConflictProps {
    number: number;
    piece: Extract<Piece, { kind: 'conflict' }>;
    choice: Choice | undefined;
    choose: (choice: Choice) => void;
}

function Conflict({ number, piece, choice, choose }: ConflictProps) {
    return (
        <fieldset class="conflict">
            <legend>Both of you changed this</legend>
            <div class="sides">
                <div><h3>Theirs</h3><pre>{piece.theirs.join('\n') || '(nothing)'}</pre></div>
                <div><h3>Mine</h3><pre>{piece.mine.join('\n') || '(nothing)'}</pre></div>
            </div>
            {CHOICES.map(([value, title]) => (
                <label key={value} class="pick">
                    <input type="radio" name={`conflict${number}`} checked={choice === value}
                        onChange={() => choose(value)} /> {title}
                </label>
            ))}
        </fieldset>
    );
}

interface MergeProps {
    mine: Draft;
    theirs: Draft;
    use: (text: string) => void;
    leave: () => void;
}

export function MergeView({ mine, theirs, use, leave }: MergeProps) {
    const [pieces] = useState(() => merge(mine.base, mine.text, theirs.text));
    const [choices, setChoices] = useState<Record<number, Choice>>({});
    const open = pieces.filter((piece, i) => piece.kind === 'conflict' && !choices[i]).length;
    const text = pieces.flatMap((piece, i) => chosen(piece, choices[i])).join('\n');
    return (
        <section class="merge" data-testid="merge">
            <h2>The file was changed by another meanwhile</h2>
            <p>Nothing of yours is lost, and nothing was sent to the outputs.</p>
            {pieces.map((piece, i) => piece.kind === 'same' ? null
                : piece.kind === 'conflict'
                    ? <Conflict key={i} number={i} piece={piece} choice={choices[i]}
                        choose={(choice) => setChoices({ ...choices, [i]: choice })} />
                    : <div key={i} class="taken"><h3>{TITLES[piece.kind]}</h3>
                        <pre>{piece.lines.join('\n') || '(lines removed)'}</pre></div>)}
            <div class="row">
                <button class="main" disabled={open > 0} onClick={() => use(text)}>
                    {open > 0 ? `Choose ${open} more` : 'Edit the merged text'}
                </button>
                <button onClick={() => use(theirs.text)}>Take theirs, drop mine</button>
                <button onClick={leave}>Not now</button>
            </div>
        </section>
    );
}
