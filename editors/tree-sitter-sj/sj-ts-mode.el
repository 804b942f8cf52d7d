;;; sj-ts-mode.el --- The language sj, by tree-sitter -*- lexical-binding: t -*-

;; Package-Requires: ((emacs "29.1"))

;;; Commentary:

;; Colours, indentation and a list of declarations for `.sj' files.  The grammar is installed once, by M-x sj-ts-install-grammar;
;; this needs git and a C compiler.

;;; Code:

(require 'treesit)

(defconst sj-ts-folder (file-name-directory (or load-file-name buffer-file-name))
  "Where this file is: beside the grammar.")

(defvar sj-ts-keywords
  '("about" "acts" "add" "after" "agents" "aim" "along" "always" "and" "as" "at" "avoiding" "away" "blocks" "but" "by" "capped" "case"
    "chance" "checks" "choose" "chose" "cite" "conserved" "define" "draw" "drop" "each" "episode" "episodes" "event" "expect" "extends"
    "facing" "field" "final" "first" "focal" "for" "forbid" "from" "game" "give" "glyph" "group" "hide" "in" "is" "kind" "let" "look" "map"
    "mark" "match" "mean" "metrics" "monotone" "move" "movers" "moves" "not" "observe" "of" "on" "once" "or" "otherwise" "over" "param"
    "phase" "pick" "policy" "random" "remove" "require" "scenario" "schedule" "seek" "send" "set" "shape" "show" "size" "sj" "slots"
    "symmetric" "tally" "timer" "to" "toward" "variant" "when" "where" "window" "with" "wraps")
  "Words of the language; those that are nodes of their own are not among them.")

(defun sj-ts-font-lock ()
  "Return what is coloured how."
  (treesit-font-lock-rules
   :language 'sj :feature 'comment '((comment) @font-lock-comment-face)
   :language 'sj :feature 'string '((string) @font-lock-string-face)
   :language 'sj :feature 'keyword
   `([,@sj-ts-keywords (end) (ahead) (all)] @font-lock-keyword-face
     (all_but "all" @font-lock-keyword-face)
     (count "count" @font-lock-builtin-face)
     (some "any" @font-lock-builtin-face)
     (every "all" @font-lock-builtin-face)
     (sum "sum" @font-lock-builtin-face)
     (unit "count" @font-lock-type-face))
   :language 'sj :feature 'definition
   '((game name: (identifier) @font-lock-type-face)
     (kind name: (identifier) @font-lock-type-face)
     (group name: (identifier) @font-lock-type-face)
     (movers name: (identifier) @font-lock-type-face)
     (shape name: (identifier) @font-lock-type-face)
     (size name: (identifier) @font-lock-constant-face)
     (param name: (identifier) @font-lock-constant-face)
     (define name: (identifier) @font-lock-function-name-face)
     (phase name: (identifier) @font-lock-function-name-face)
     (policy name: (identifier) @font-lock-function-name-face)
     (scenario name: (identifier) @font-lock-function-name-face)
     (variant name: (identifier) @font-lock-function-name-face)
     (field name: (identifier) @font-lock-property-name-face)
     (timer name: (identifier) @font-lock-property-name-face)
     (let name: (identifier) @font-lock-variable-name-face)
     (draw name: (identifier) @font-lock-variable-name-face)
     (bind name: (identifier) @font-lock-variable-name-face))
   :language 'sj :feature 'type
   '((unit (identifier) @font-lock-type-face)
     (domain kind: (identifier) @font-lock-type-face)
     (on kind: (identifier) @font-lock-type-face)
     (on_expression kind: (identifier) @font-lock-type-face))
   :language 'sj :feature 'constant
   '((words (identifier) @font-lock-constant-face)
     (action name: (identifier) @font-lock-constant-face)
     (nobody) @font-lock-constant-face
     [(integer) (decimal)] @font-lock-number-face)
   :language 'sj :feature 'property
   '((member name: (identifier) @font-lock-property-use-face)
     (call function: (identifier) @font-lock-function-call-face)
     (extreme function: (identifier) @font-lock-function-call-face)
     (turn phase: (identifier) @font-lock-function-call-face))))

(defconst sj-ts-braces
  "\\`\\(?:declarations\\|block\\|rows\\|words\\|table\\|case\\|kind\\|agents\\|movers\\|observe\\|metrics\\|checks\\|policy\\|scenario\\)\\'"
  "Nodes whose content stands in braces.")

(defun sj-ts-unfinished-p (node parent bol)
  "Return whether NODE at BOL is in an open brace that PARENT does not know.
A text that is being written has braces that nothing closes yet."
  (and (or (null node) (null parent) (member (treesit-node-type parent) '("source_file" "ERROR")))
       (nth 1 (syntax-ppss bol))))

(defun sj-ts-opening-line (node parent bol)
  "Return where the text of the line begins that opens the braces around BOL.
NODE is what stands there, in PARENT."
  (let ((type (and parent (treesit-node-type parent))))
    (save-excursion
      (goto-char (cond ((sj-ts-unfinished-p node parent bol))
                       ((member type '("declarations" "block" "rows" "words" "table")) (treesit-node-start (treesit-node-parent parent)))
                       (t (treesit-node-start parent))))
      (back-to-indentation)
      (point))))

(defun sj-ts-first-text (parent)
  "Return the first text in quotes of PARENT."
  (treesit-search-subtree parent "\\`string\\'"))

(defun sj-ts-below-a-text-p (node parent _bol)
  "Return whether NODE is a text of PARENT under its first one.
That one begins in the middle of a line."
  (and node
       (equal (treesit-node-type node) "string")
       (member (treesit-node-type parent) '("about" "rows"))
       (save-excursion
         (goto-char (treesit-node-start (sj-ts-first-text parent)))
         (not (looking-back "^[ \t]*" (pos-bol))))))

(defvar sj-ts-indent
  `((sj
     ((node-is "}") sj-ts-opening-line 0)
     (sj-ts-unfinished-p sj-ts-opening-line 2)
     ((parent-is "source_file") column-0 0)
     ((match "\\`otherwise\\'" "\\`\\(?:when\\|chance\\|pick\\|first\\)\\'") parent-bol 0)
     (sj-ts-below-a-text-p (lambda (_ parent _) (treesit-node-start (sj-ts-first-text parent))) 0)
     ((match "relabel" "show") sj-ts-opening-line 2)
     ((parent-is ,sj-ts-braces) sj-ts-opening-line 2)
     (catch-all parent-bol 4)))
  "How far in a line stands: as `sjdsl fmt' has it.")

(defun sj-ts-name (node)
  "Return the name that the declaration NODE gives."
  (treesit-node-text (treesit-node-child-by-field-name node "name") t))

(defun sj-ts-install-grammar ()
  "Compile the grammar beside this file, and install it."
  (interactive)
  (let ((treesit-language-source-alist
         `((sj ,(expand-file-name "../.." sj-ts-folder) nil "editors/tree-sitter-sj/src"))))
    (treesit-install-language-grammar 'sj)))

(defvar sj-ts-mode-syntax-table
  (let ((table (make-syntax-table)))
    (modify-syntax-entry ?# "<" table)
    (modify-syntax-entry ?\n ">" table)
    (modify-syntax-entry ?_ "_" table)
    table)
  "Comments run from # to the end of the line.")

;;;###autoload
(define-derived-mode sj-ts-mode prog-mode "SJ"
  "Major mode for games in the language sj."
  (setq-local comment-start "# "
              comment-start-skip "#+ *"
              indent-tabs-mode nil)
  (when (treesit-ready-p 'sj)
    (treesit-parser-create 'sj)
    (setq-local treesit-font-lock-settings (sj-ts-font-lock)
                treesit-font-lock-feature-list '((comment definition) (keyword string) (constant type) (property))
                treesit-simple-indent-rules sj-ts-indent
                treesit-defun-type-regexp "\\`\\(?:phase\\|define\\|policy\\|variant\\|agents\\|kind\\)\\'"
                treesit-defun-name-function #'sj-ts-name
                treesit-simple-imenu-settings
                '(("Kind" "\\`kind\\'" nil sj-ts-name) ("Number" "\\`\\(?:size\\|param\\|define\\)\\'" nil sj-ts-name)
                  ("Phase" "\\`phase\\'" nil sj-ts-name) ("Policy" "\\`policy\\'" nil sj-ts-name)
                  ("Variant" "\\`variant\\'" nil sj-ts-name)))
    (treesit-major-mode-setup)))

;;;###autoload
(add-to-list 'auto-mode-alist '("\\.sj\\'" . sj-ts-mode))

(with-eval-after-load 'eglot
  (defvar eglot-server-programs)
  (add-to-list 'eglot-server-programs '(sj-ts-mode . ("sjdsl" "lsp"))))

(provide 'sj-ts-mode)
;;; sj-ts-mode.el ends here
