"""A real mosquitto, and a client that reads what it is told."""
import json
import signal
import socket
import subprocess
import threading
import time

import paho.mqtt.client

from board import end_with_this_process, eventually, free_port


class Broker:
    """Debian's mosquitto at a port of its own. It keeps subscriptions at once, also over a kill: so
    a reader that comes back later than the bridge misses nothing."""
    KEEPS_AT_ONCE = ("autosave_on_changes true", "autosave_interval 1")

    def __init__(self, folder, *lines, keeps=KEEPS_AT_ONCE):
        self.folder, self.port = folder, free_port()
        self.file = folder / f"mosquitto-{self.port}.conf"
        self.file.write_text("\n".join((
            f"listener {self.port} 127.0.0.1", "user root", "persistence true",
            f"persistence_location {folder}/", f"persistence_file kept-{self.port}.db",
            *keeps, *lines)))
        self.start()

    def start(self):
        with open(self.folder / "mosquitto.log", "ab") as log:
            self.process = subprocess.Popen(  # pylint: disable=consider-using-with
                ["mosquitto", "-c", self.file], stdout=log, stderr=log,
                preexec_fn=end_with_this_process)
        assert eventually(self.listens, pause_s=0.05), "mosquitto does not listen"

    def listens(self):
        with socket.socket() as one:
            return one.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        self.process.wait(30)


class Reader:
    """Keeps every message below the topics, with the time at which it came."""

    def __init__(self, port, *topics):
        self.messages, self.lock, self.ready = [], threading.Lock(), threading.Event()
        self.client = paho.mqtt.client.Client(f"reader-{id(self)}", clean_session=False,
                                              protocol=paho.mqtt.client.MQTTv311)
        self.client.on_connect = lambda client, *_: client.subscribe(
            [(topic, 1) for topic in topics])
        self.client.on_subscribe = lambda *_: self.ready.set()
        self.client.on_message = self._take
        # Comes back at once: a later reader would see its own pauses in what it measures.
        self.client.reconnect_delay_set(min_delay=1, max_delay=1)
        self.client.connect("127.0.0.1", port)
        self.client.loop_start()
        assert self.ready.wait(30), "no subscription"

    def _take(self, _client, _self, message):
        with self.lock:
            self.messages.append((time.time(), message.topic, message.payload.decode(), message))

    def of(self, topic):
        with self.lock:
            return [message for message in self.messages if message[1] == topic]

    def last(self, topic):
        found = self.of(topic)
        return found[-1][2] if found else None

    def objects(self, topic):
        return [json.loads(message[2]) for message in self.of(topic)]

    def say(self, topic, payload):
        self.client.publish(topic, payload, qos=1).wait_for_publish()

    def close(self):
        self.client.disconnect()
        self.client.loop_stop()
