"""Video files, decoded one frame after the other with the time stamps of the container."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from camid.errors import InputError
from camid.tracking.integrity import MPEG4_SUFFIXES, ends_early, lacks_index
from camid.tracking.picture import Picture, picture_of

# Share of the announced duration that may be missing where the container does not count its frames.
DURATION_TOLERANCE = 0.02
# FFmpeg takes any text for a picture made of letters.
TEXT_FORMATS = frozenset({"tty"})
RE_ENCODE = "re-encode it, e.g. as H.264"
NAME_A_VIDEO = "name an MP4 or AVI file, or a folder of PNG"


@dataclass(frozen=True)
class Frame:
    """One picture and when it was taken.

    Attributes
    ----------
    number : int
        Counted from 0 in the file.
    time : float
        Seconds, the time stamp of the container.
    picture : Picture
    """

    number: int
    time: float
    picture: Picture


class Source(Protocol):
    """A source of frames that can be read repeatedly."""

    name: str
    expected: int | None
    notes: list[str]

    def frames(self, start: float | None = None, end: float | None = None) -> Iterator[Frame]:
        """Frames from ``start`` to ``end`` in seconds, both included."""
        ...


class VideoFile:
    """A video file that FFmpeg decodes.

    Parameters
    ----------
    path : path
    frame_rate : float, optional
        Frames per second, for a stream that has no time stamps; refused where there are some.
    allow_truncated : bool
        Take what can be read of a file that ends in the middle.
    threads : int
        Threads that decode.

    Raises
    ------
    InputError
        If the file is not a video, lacks its index, or its codec is not known.
    """

    def __init__(
        self, path: Path, *, frame_rate: float | None = None, allow_truncated: bool = False, threads: int = 1
    ) -> None:
        self.path, self.name = path, str(path)
        self.frame_rate, self.allow_truncated, self.threads = frame_rate, allow_truncated, threads
        self.notes: list[str] = []
        with self._open() as container:
            stream = container.streams.video[0]
            self.expected: int | None = stream.frames or None
            ratio = stream.sample_aspect_ratio
            if ratio is not None and ratio not in {0, 1}:
                self.notes.append(f"the pixels are not square (width to height {ratio}): x and y differ in scale")

    def _open(self) -> Any:
        import av

        try:
            # Only this file: a playlist cannot fetch anything from elsewhere.
            container = av.open(f"file:{self.path}", options={"protocol_whitelist": "file"})
        except (av.error.FFmpegError, ValueError) as error:
            if lacks_index(self.path):
                raise InputError(
                    "the file is truncated: its index ('moov') is missing",
                    where=self.name,
                    hint="close the recording properly, or repair it (untrunc)",
                ) from None
            reason = getattr(error, "strerror", None) or "unreadable"
            raise InputError(f"this is not a video ({reason})", where=self.name, hint=NAME_A_VIDEO) from None
        problem = ""
        if container.format.name in TEXT_FORMATS:
            problem = "this is not a video (text)"
        elif not container.streams.video:
            problem = "there is no video in the file"
        elif container.streams.video[0].codec_context is None:
            problem = "the codec of the video is not known"
        if problem:
            container.close()
            raise InputError(problem, where=self.name, hint=RE_ENCODE if "codec" in problem else NAME_A_VIDEO)
        return container

    def frames(self, start: float | None = None, end: float | None = None) -> Iterator[Frame]:
        """Frames from ``start`` to ``end`` in seconds, both included.

        Raises
        ------
        InputError
            If frames have no time stamps or such as do not increase, or the file ends in the middle.
        """
        count, last, broken = 0, None, False
        with self._open() as container:
            stream = container.streams.video[0]
            for frame in self._decoded(container, stream):
                if frame is None:
                    broken = True
                    break
                time = self._time(frame, count)
                if last is not None and time <= last:
                    raise InputError(
                        f"the time stamps do not increase ({last:.6g} s, then {time:.6g} s)",
                        where=f"{self.name}, frame {count}",
                        hint="rewrite the file, e.g. ffmpeg -i FILE -fps_mode cfr NEW.mp4",
                    )
                if end is not None and time > end:
                    return
                if count == 0:
                    self._look_at(frame)
                if start is None or time >= start:
                    yield Frame(count, time, picture_of(frame))
                count, last = count + 1, time
            broken = broken or self._ends_early(container, last, count)
        if not broken:
            return
        sentence = f"the video is truncated: {count} frames could be read{self._of_expected(count)}"
        if self.allow_truncated:
            self._note(sentence)
        else:
            raise InputError(
                sentence,
                where=self.name,
                hint="copy the file again, or take what there is with --allow-truncated",
            )

    def _of_expected(self, count: int) -> str:
        return f" of {self.expected}" if self.expected is not None and self.expected > count else ""

    def _decoded(self, container: Any, stream: Any) -> Iterator[Any]:
        """Frames, and None where the stream breaks off."""
        import av

        stream.codec_context.thread_count = self.threads
        stream.codec_context.thread_type = "NONE" if self.threads == 1 else "AUTO"
        first = True
        try:
            for frame in container.decode(stream):
                if frame.is_corrupt:
                    yield None
                    return
                first = False
                yield frame
        except av.error.FFmpegError as error:
            if first:
                raise InputError(
                    f"the video cannot be decoded ({stream.codec_context.name}: {error.strerror})",
                    where=self.name,
                    hint=RE_ENCODE,
                ) from None
            yield None

    def _time(self, frame: Any, count: int) -> float:
        if frame.pts is None:
            if self.frame_rate is None:
                raise InputError(
                    "the video has no time stamps",
                    where=f"{self.name}, frame {count}",
                    hint="put it into a container that has them, e.g. MP4, or say --frame-rate",
                )
            return count / self.frame_rate
        if self.frame_rate is not None:
            raise InputError("the video has its own time stamps", where=self.name, hint="leave out --frame-rate")
        return float(frame.pts * frame.time_base)

    def _note(self, sentence: str) -> None:
        if sentence not in self.notes:
            self.notes.append(sentence)

    def _look_at(self, frame: Any) -> None:
        if frame.rotation:
            self._note(
                f"players turn this video by {frame.rotation}°, camid does not: x and y are those of the stored image"
            )
        if frame.interlaced_frame:
            self._note("the video is interlaced: the two halves of a frame were taken at different times")

    def _ends_early(self, container: Any, last: float | None, count: int) -> bool:
        if self.path.suffix.lower() in MPEG4_SUFFIXES | {".avi"}:
            return ends_early(self.path)
        # Matroska and others announce a duration; the sound may last longer than the video.
        if last is None or container.duration is None or len(container.streams) != 1 or count < 2:
            return False
        first_time = (container.start_time or 0) / 1e6
        duration = container.duration / 1e6
        return first_time + duration - last > max(
            3.0 * (last - first_time) / (count - 1), DURATION_TOLERANCE * duration
        )
