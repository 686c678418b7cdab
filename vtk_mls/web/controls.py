"""Controls that several parts of the page have."""

from trame.widgets import vuetify3 as v

from vtk_mls.editor.commands import with_key

_FIELD = {"density": "compact", "variant": "outlined", "hide_details": True}


def wide_button(text, icon, click, **options):
    """A button as wide as the panel."""
    v.VBtn(text, prepend_icon=icon, block=True, variant="tonal", click=click, **options)


def small_button(text, icon, click, variant="tonal", **options):
    v.VBtn(text, prepend_icon=icon, size="small", variant=variant, click=click, **options)


def icon_button(icon, title, click, density="comfortable", **options):
    v.VBtn(icon=icon, title=title, click=click, density=density, **options)


def select(name, label, items, edit):
    """A list of choices that sets a value; `items` are as of VSelect."""
    change = edit, f"['{name}', $event]"
    v.VSelect(items=items, model_value=(name,), update_modelValue=change, label=label, **_FIELD)


def text_field(value, label, change, **options):
    """A field that shows the value of an expression; `change` is as of VTextField."""
    v.VTextField(model_value=(value,), label=label, change=change, **_FIELD, **options)


def toggle(name, choices, edit, method):
    """A row of buttons that set a value; `choices` are pairs (value, text).

    The tool tips have the keys of a method of the editor.
    """
    look = {"variant": "outlined", "density": "compact", "color": "primary", "classes": "d-flex"}
    look.update(mandatory=True, divided=True, update_modelValue=(edit, f"['{name}', $event]"))
    with v.VBtnToggle(model_value=(name,), **look):
        for value, text in choices:
            title = with_key(text, method, value)
            v.VBtn(text, value=value, classes="flex-grow-1", size="small", title=title)


def slider(name, label, steps, edit, **options):
    """A slider that sets a value when it or its key is released; `steps` are (low, high, step)."""
    low, high, step = steps
    v.VSlider(
        min=low,
        max=high,
        step=step,
        model_value=(name,),
        end=(edit, f"['{name}', $event]"),
        # keys of a slider, which have names, give no event `end`; letters are keys of the editor
        keyup=(
            edit,
            f"[$event.key.length > 1 ? '{name}' : '', "
            "Number($event.target.getAttribute('aria-valuenow'))]",
        ),
        color="primary",
        density="compact",
        hide_details=True,
        raw_attrs=[f'aria-label="{label}"'],
        **options,
    )
