// Mistakes, differences and the picture below the editor.
import type { Mistake } from '../model/status';
import { Icon } from '../parts/icons';
import { picture, verdict, type ChangedOutput } from './checking';

function Mistakes({ mistakes, goTo }: { mistakes: Mistake[]; goTo: (mistake: Mistake) => void }) {
    const title = mistakes.length === 1 ? '1 mistake' : `${mistakes.length} mistakes`;
    return (
        <>
            <h2><Icon name="failsafe" />{title}</h2>
            <ul class="mistakes">
                {mistakes.map((one) => (
                    <li key={`${one.line}:${one.column}:${one.text}`}>
                        {one.line === 0 ? <span>{one.text}</span>
                            : <button class="plain" onClick={() => goTo(one)}>
                                {one.line}:{one.column}: {one.text}
                            </button>}
                    </li>
                ))}
            </ul>
        </>
    );
}

function Differences({ lines, same }: { lines: string[]; same: boolean }) {
    return same || lines.length === 0
        ? <p class="quiet">The same as what runs.</p>
        : <><h2>What changes</h2><pre class="diff">{lines.join('\n')}</pre></>;
}

const microseconds = (pulse: number | null): string => (pulse === null ? 'none' : `${pulse}`);

function ThenView({ outputs }: { outputs: ChangedOutput[] }) {
    if (outputs.length === 0) {
        return null;
    }
    return (
        <>
            <h2>With the sticks as they are</h2>
            <ul class="then">{outputs.flatMap((one) => one.channels.map((channel) => (
                <li key={`${one.output}${channel.channel}`}>
                    {one.output}, channel {channel.channel}: now {microseconds(channel.now_us)},
                    then {microseconds(channel.then_us)} us
                </li>
            )))}</ul>
        </>
    );
}

export function VerdictView({ goTo }: { goTo: (mistake: Mistake) => void }) {
    const now = verdict.value;
    return (
        <section class="verdict" aria-label="Check" data-testid="verdict">
            <div role="status">
                {now === null ? <p class="quiet">Waiting for the board to check this text.</p>
                    : now.error ? <p class="error">Not checked: {now.error}</p>
                    : now.mistakes.length > 0 ? <Mistakes mistakes={now.mistakes} goTo={goTo} />
                    : now.lines ? (
                        <>
                            <Differences lines={now.lines} same={now.same} />
                            <ThenView outputs={now.outputs} />
                        </>
                    )
                    : <p>No mistakes. No daemon runs that it could be compared with.</p>}
            </div>
            {picture.value && (
                <details>
                    <summary>Picture of this text</summary>
                    <img src={picture.value} alt="Inputs, pipelines and outputs of the draft" />
                </details>
            )}
        </section>
    );
}
