// What stands around every screen: top bar, navigation, banners.
import type { ComponentChildren } from 'preact';
import { goOn } from '../model/connection';
import {
    absent, addressOf, daemonName, daemons, freshness, lastListed, me, offers, screen, type Screen,
    streamEnded, theme, THEMES,
} from '../model/store';
import { Icon, type IconName } from './icons';
import { TrialStrip } from './trial_strip';

const TITLES: Record<Screen, string> = {
    live: 'Live', timing: 'Timing', config: 'Configuration', doctor: 'Doctor', learn: 'Learn',
    recordings: 'Recordings', more: 'More',
};
const ON_DESKTOP: Screen[] = ['live', 'timing', 'config', 'doctor', 'learn', 'recordings', 'more'];
const ON_PHONE: [Screen, string, IconName][] = [
    ['live', 'Live', 'live'], ['timing', 'Timing', 'timing'], ['config', 'Config', 'config'],
    ['more', 'More', 'more'],
];

function Lamp() {
    const { level, short } = freshness.value;
    const text = absent.value ? 'no daemon' : short;
    const icon: IconName = level === 'live' ? 'live' : level === 'late' ? 'hold' : 'silent';
    return <span class={`lamp ${level}`} data-testid="lamp"><Icon name={icon} />{text}</span>;
}

export function ThemeButton() {
    const next = THEMES[(THEMES.indexOf(theme.value) + 1) % THEMES.length] ?? 'system';
    return (
        <button class="plain" onClick={() => { theme.value = next; }}
            aria-label={`Colours: ${theme.value}. Change to ${next}`}>
            <Icon name="colours" /><span class="word">{theme.value}</span>
        </button>
    );
}

function DaemonChoice() {
    const list = daemons.value ?? [];
    if (list.length < 2) {
        return <strong class="name">{daemonName.value || me.value?.host || 'tribus'}</strong>;
    }
    return (
        <select class="name" aria-label="Daemon" value={daemonName.value}
            onChange={(event) => {
                location.hash = addressOf(screen.value, event.currentTarget.value);
            }}>
            {list.map((one) => (
                <option key={one.name} value={one.name}>
                    {one.name}{one.state === 'running' ? '' : ` (${one.state})`}
                </option>
            ))}
        </select>
    );
}

function TopBar() {
    return (
        <header class="top">
            <DaemonChoice />
            <nav class="wide" aria-label="Screens">
                {ON_DESKTOP.filter(offers).map((one) => (
                    <a key={one} href={addressOf(one)}
                        aria-current={screen.value === one ? 'page' : undefined}>
                        {TITLES[one]}
                    </a>
                ))}
            </nav>
            <Lamp />
            <ThemeButton />
        </header>
    );
}

function BottomBar() {
    const behindMore = ['doctor', 'learn', 'recordings', 'more'].includes(screen.value);
    return (
        <nav class="bottom" aria-label="Screens, short">
            {ON_PHONE.map(([one, title, icon]) => {
                const here = one === screen.value || (one === 'more' && behindMore);
                return (
                    <a key={one} href={addressOf(one)} aria-current={here ? 'page' : undefined}>
                        <Icon name={icon} />{title}
                    </a>
                );
            })}
        </nav>
    );
}

/** Says that nothing on the page is live. It stays in the document, so that it is read out. */
function StaleBanner() {
    const { level, text } = freshness.value;
    const shown = level === 'stale' && !absent.value;
    return (
        <section class="stale-banner" data-testid="stale" aria-label="Connection" hidden={!shown}>
            {/* The running age is not read out again and again. */}
            <span role="status" class="unseen">
                {shown ? 'Nothing on this page is live now.' : ''}
            </span>
            <strong>{shown ? text + lastListed.value : ''}</strong>
            {streamEnded.value && <button onClick={goOn}>Go on here</button>}
        </section>
    );
}

export function Frame({ children }: { children: ComponentChildren }) {
    return (
        <div class="frame" data-level={absent.value ? 'stale' : freshness.value.level}>
            <TopBar />
            {me.value?.public && (
                <aside class="public" aria-label="Warning">
                    Nothing is encrypted: others in this network can read along.
                </aside>
            )}
            <StaleBanner />
            <TrialStrip />
            <main id="main">
                <h1 class="unseen">{TITLES[screen.value]}</h1>
                {children}
            </main>
            <BottomBar />
        </div>
    );
}
