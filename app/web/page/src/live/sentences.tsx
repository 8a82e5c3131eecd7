// One line in words for each output, and what else needs attention.
import { freshness, status } from '../model/store';
import type { Output, Status } from '../model/status';
import { Icon, type IconName } from '../parts/icons';
import { attention } from './attention';

const ICONS: Record<string, IconName> = {
    control: 'control', hold: 'hold', failsafe: 'failsafe', silent: 'silent', cannot_send: 'silent',
};

/** An output that waits for its first receiver is no alarm, but it is not in control either. */
export function lookOf(output: Output, status: Status): string {
    const inputs = status.inputs.filter((one) => output.inputs.includes(one.name));
    const waits = !output.forced && inputs.length > 0
        && inputs.every((one) => one.cause === 'never_seen');
    return waits && output.state !== 'cannot_send' ? 'waiting' : output.state;
}

function Sentence({ output, status }: { output: Output; status: Status }) {
    const look = lookOf(output, status);
    const old = freshness.value.level === 'stale';
    const waits = look === 'waiting' ? 'waiting: ' : '';
    return (
        <li class="sentence" data-state={look} data-output={output.name}>
            <Icon name={look === 'waiting' ? 'waiting' : ICONS[output.state] ?? 'note'} />
            <span class="name">{output.name}</span>
            <p class="said">
                {old && <span class="before">Last known: </span>}
                <span class="value">{waits}{output.text}</span>
            </p>
            <p class="why"><span class="value">{output.why}</span></p>
        </li>
    );
}

/** Read out when a state changes; without times, which would be read again and again. */
function spoken(now: Status): string {
    return freshness.value.level !== 'live' ? ''
        : now.outputs.map((one) => `${one.name}: ${one.text}`).join('; ');
}

export function Sentences() {
    const now = status.value;
    if (!now) {
        return null;
    }
    const others = attention(now);
    return (
        <section aria-label="Outputs">
            <p class="unseen" role="status">{spoken(now)}</p>
            <ul class="sentences">
                {now.outputs.map((one) => <Sentence key={one.name} output={one} status={now} />)}
            </ul>
            {others.length === 0
                ? <p class="quiet"><span class="value">Nothing else needs attention.</span></p>
                : (
                    <ul class="attention" data-testid="attention">
                        {others.map((text) => (
                            <li key={text.split(':')[0] + text.length}>
                                <Icon name="failsafe" /><span class="value">{text}</span>
                            </li>
                        ))}
                    </ul>
                )}
        </section>
    );
}
