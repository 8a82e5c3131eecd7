// What state each input and output was in, as stripes over the last ten minutes.
import { KEPT_S, type Spell } from '../model/history';
import { duration, words } from '../model/words';

const LOOKS: Record<string, string> = {
    good: 'fine', control: 'fine', hold: 'hold', never_seen: 'waiting',
};
const lookOf = (word: string): string => LOOKS[word] ?? 'bad';

/** The longest spells of trouble in words, newest first. */
function troubles(spells: Spell[]): Spell[] {
    return spells.filter((one) => lookOf(one.word) !== 'fine').slice(-3).reverse();
}

/** A spell that was renewed just now goes on. */
const GOES_ON_S = 0.4;

function endOf(spell: Spell, now: number): string {
    const since = now - spell.to;
    return since < GOES_ON_S ? 'now' : `until ${duration(since * 1e6)} ago`;
}

function Stripe({ name, spells, now }: { name: string; spells: Spell[]; now: number }) {
    const share = (at: number) => Math.max(0, 1 - (now - at) / KEPT_S) * 100;
    const bad = troubles(spells);
    return (
        <div>
            <h3>{name}</h3>
            <div class="stripe" aria-hidden="true">
                {spells.map((one) => (
                    <span key={one.from} class={lookOf(one.word)} style={{
                        left: `${share(one.from)}%`,
                        width: `${share(one.to) - share(one.from)}%`,
                    }} />
                ))}
            </div>
            <p class="quiet">
                {bad.length === 0 ? 'No trouble in what was seen.' : bad.map((one) =>
                    `${words(one.word)} for ${duration((one.to - one.from) * 1e6)}, `
                    + endOf(one, now)).join('; ')}
            </p>
        </div>
    );
}

export function Stripes({ spells, now }: { spells: ReadonlyMap<string, Spell[]>; now: number }) {
    return (
        <section class="stripes" aria-label="States">
            <h2>States of the last 10 minutes</h2>
            {[...spells].map(([name, list]) => (
                <Stripe key={name} name={name} spells={list} now={now} />
            ))}
            <p class="key" aria-hidden="true">
                <span><i class="stripe"><span class="fine left" /></i>good, control</span>
                <span><i class="stripe"><span class="hold left" /></i>hold</span>
                <span><i class="stripe"><span class="bad left" /></i>lost, failsafe</span>
                <span><i class="stripe" />this page saw nothing</span>
            </p>
        </section>
    );
}
