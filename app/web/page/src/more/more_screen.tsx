import { useState } from 'preact/hooks';
import { errorText } from '../model/api';
import { leave } from '../model/session';
import { addressOf, me, offers } from '../model/store';

const LINKS = [
    ['doctor', 'Doctor', 'What the ports and the machine can do, and what to fix'],
    ['learn', 'Learn', 'Find out how a receiver loses its link'],
    ['recordings', 'Recordings', 'What passed the ports before a failsafe'],
] as const;

export function MoreScreen() {
    const [error, setError] = useState('');
    const role = me.value?.role === 'change' ? 'look and change' : 'only look';
    return (
        <>
            <ul class="links">
                {LINKS.filter(([screen]) => offers(screen)).map(([screen, title, text]) => (
                    <li key={screen}>
                        <a href={addressOf(screen)}><strong>{title}</strong><span>{text}</span></a>
                    </li>
                ))}
            </ul>
            <p>Board {me.value?.host}, tribus {me.value?.version}. This browser may {role}.</p>
            <button onClick={() => void leave().catch((failed) => setError(errorText(failed)))}>
                Leave: forget this browser
            </button>
            <p class="error" role="alert">{error}</p>
        </>
    );
}
