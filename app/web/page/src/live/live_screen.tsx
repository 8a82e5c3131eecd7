import { absent, addressOf, daemon, offers, status } from '../model/store';
import { Facts } from './facts';
import { Pairs } from './pairs';
import { Sentences } from './sentences';

function Absent() {
    return (
        <div class="empty" data-testid="absent">
            <p class="large">No daemon runs for {daemon.value?.file}.</p>
            <p>Nothing is translated, and nothing on this page is live. The configuration can be
                edited and checked; on the board, <code>systemctl status</code> says why the daemon
                ended.</p>
            <p class="row"><a class="button" href={addressOf('config')}>Open the configuration</a>
                {offers('doctor') &&
                    <a class="button" href={addressOf('doctor')}>Ask Doctor</a>}</p>
        </div>
    );
}

/** The first-time screen: no receiver was ever heard. */
function NeverHeard() {
    const inputs = status.value?.inputs ?? [];
    const unheard = inputs.filter((one) => one.cause === 'never_seen');
    return unheard.length === 0 ? null : (
        <p class="hint">
            Nothing has been heard on {unheard.map((one) => one.port).join(', ')}: look at what
            sends there, and at the way from it to this board.{' '}
            {offers('doctor')
                ? <a href={addressOf('doctor')}>Doctor can listen.</a>
                : <>On the board, <code>tribus doctor</code> can listen.</>}
        </p>
    );
}

export function LiveScreen() {
    if (absent.value) {
        return <Absent />;
    }
    if (!status.value) {
        return <p class="empty">No status has come yet. This page shows values only while they are
            live.</p>;
    }
    return (
        <div class="live-screen">
            <Sentences />
            <NeverHeard />
            <Pairs />
            <Facts />
        </div>
    );
}
